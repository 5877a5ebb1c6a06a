// What differs between two configurations, link by link, in the words of their keys.
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
    std::vector<std::string> differences;    // of a changed one: "baud: 500000 -> 115200"
};

struct Difference {
    std::vector<LinkDifference> links;    // those of the new configuration in its order, then those that go; the tunnel is one
    std::vector<std::string> gateway;     // of all else: takes effect while the gateway runs
    std::vector<std::string> needs_restart;    // the same: takes effect at the next start

    /// Nothing is to be done while it runs.
    bool is_none() const noexcept;
    /// Of a link that is in neither: Change::same.
    Change of(std::string_view link) const noexcept;
};

/// Both must be without fault. A link is the one of the same name; what belongs to a link and stands elsewhere (its aliases, the
/// GPIO line of its transceiver) counts as its own.
Difference difference(const Settings& before, const Settings& after);

/// `after` as far as it takes effect while `running` runs: the control socket and the place of the log stay.
Settings without_restart(const Settings& running, Settings after);

}    // namespace anogate
