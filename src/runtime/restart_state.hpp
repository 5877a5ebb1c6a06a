// The state that a gateway passes to its next run: open descriptors, peers, learned addresses, and the frames received on links
// of groups.
#pragma once
#include <gateway/duplicate_guard.hpp>
#include <link/stored_link.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class Gateway;

struct StoredAddress {
    std::uint8_t address = 0;
    ano::TimePoint heard_at{};
};

/// A channel of a link, identified by the displayed name of its peer.
struct StoredChannel {
    std::string peer;
    std::vector<StoredAddress> addresses{};
    std::vector<std::uint8_t> first{};    // addresses first heard there, before they moved
};

/// Identifies the file of an open descriptor, independent of the number of the descriptor.
struct WireIdentity {
    std::uint64_t device = 0, inode = 0;    // both 0: none

    static WireIdentity of(int fd) noexcept;
    friend bool operator==(const WireIdentity&, const WireIdentity&) = default;
};

struct RestartState {
    struct OfLink {
        std::string name;
        WireIdentity wire{};
        StoredLink link{};
        std::vector<StoredChannel> channels{};
        std::vector<DuplicateGuard::Memory> brought{};    // frames received on a link of a group
    };
    ClockReading unread_since{};
    std::vector<OfLink> links{};
};

/// The maximum number of frames of groups; the newest ones are stored.
inline constexpr std::size_t max_stored_frames = 4096;

/// The gateway must have stopped reading. The descriptors are duplicates: both programs have them open until the gateway closes
/// its own.
RestartState state_of(const Gateway& gateway, const ClockReading& unread_since);

/// The state without the descriptors, as text.
std::string to_string(const RestartState& state);
/// std::nullopt: the text is of another version of the program, or its times are after `now`. The caller adds the descriptors.
std::optional<RestartState> parse_restart_state(std::string_view text, const ClockReading& now);

}    // namespace anogate
