// What a gateway leaves to the one that is started next: open wires, peers, where addresses were heard, and what came by
// the links of groups.
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

/// Of a link, by the name that people read.
struct StoredChannel {
    std::string peer;
    std::vector<StoredAddress> addresses{};
    std::vector<std::uint8_t> first{};    // addresses that were at home there before they moved
};

/// Which file an open descriptor is of, whatever number it has.
struct WireIdentity {
    std::uint64_t device = 0, inode = 0;    // both 0: none

    static WireIdentity of(int fd) noexcept;
    friend bool operator==(const WireIdentity&, const WireIdentity&) = default;
};

struct StoredState {
    struct OfLink {
        std::string name;
        WireIdentity wire{};
        StoredLink link{};
        std::vector<StoredChannel> channels{};
        std::vector<DuplicateGuard::Memory> brought{};    // of a link of a group
    };
    ClockReading unread_since{};
    std::vector<OfLink> links{};
};

/// Of the frames of groups the newest, so many in all.
inline constexpr std::size_t max_stored_frames = 4096;

/// Of a gateway that reads no more. Its wires are copies: both programs have them until it closes its own.
StoredState state_of(const Gateway& gateway);

/// All but the descriptors, as text.
std::string text_of(const StoredState& state);
/// Nothing: the text is of another version of the program, or what it says was not yet at `now`. The wires are to be put in.
std::optional<StoredState> parse_stored_state(std::string_view text, const ClockReading& now);

}    // namespace anogate
