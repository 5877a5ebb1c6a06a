// Which connections a listening TCP socket keeps when its places are used up.
#pragma once
#include <ano/time.hpp>
#include <gateway/ids.hpp>
#include <gateway/ip.hpp>

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>

namespace anogate {

struct ConnectionPlaces {
    std::size_t max = max_channels;
    std::size_t max_of_address = max_channels;    // loopback excepted
    std::size_t kept_for_trusted = 0;             // of max

    /// A connection that has sent no complete frame for this time may be closed for a new one.
    static constexpr ano::Duration silent_after = std::chrono::seconds{10};

    struct Connection {
        IpAddress address{};
        ano::TimePoint since{};
        bool has_sent_frame = false;    // it sent a complete frame
        bool is_trusted = false;
    };
    struct Place {
        bool free = false;
        std::optional<std::size_t> evicted{};    // the index of the connection that must be closed first
    };
    /// Whether there is a place for `stranger`, which connects at `now`. `all` are the current connections.
    Place place_for(std::span<const Connection> all, const IpAddress& stranger, bool is_trusted, ano::TimePoint now) const;
};

}    // namespace anogate
