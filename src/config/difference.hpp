// The differences between two configurations, per link, as key: before -> after.
#pragma once
#include <gateway/settings.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

enum class Change : std::uint8_t { same, changed, added, removed };
std::string_view text(Change change) noexcept;

struct LinkDifference {
    std::string name;
    Change change = Change::same;
    std::vector<std::string> differences;    // of a changed link: "baud: 500000 -> 115200"
};

struct Difference {
    std::vector<LinkDifference> links;    // in the order of the new configuration, then the removed ones; includes the tunnel
    std::vector<std::string> gateway;     // other changes that take effect while the gateway runs
    std::vector<std::string> needs_restart;    // other changes that take effect at the next start

    /// Whether no change takes effect while the gateway runs.
    bool is_none() const noexcept;
    /// Change::same for a link that is in neither configuration.
    Change of(std::string_view link) const noexcept;
};

/// Both must be valid. Links are matched by name. Settings of a link that are configured elsewhere (its aliases, the GPIO line of
/// its transceiver) count as part of it.
Difference difference(const Settings& before, const Settings& after);

/// `after`, but with the settings of `running` that only a restart can change: `control`, and the file and rotation of the log.
Settings without_restart(const Settings& running, Settings after);

}    // namespace anogate
