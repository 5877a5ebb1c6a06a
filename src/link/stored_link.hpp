// What a link leaves to the link of the same name in the program that is started next: its open wire, and who was behind it.
#pragma once
#include <gateway/arrival.hpp>
#include <gateway/ip.hpp>
#include <gateway/peer_book.hpp>
#include <link/unique_fd.hpp>

#include <poll.h>

#include <cstdint>
#include <vector>

namespace anogate {

/// A peer of a listening socket.
struct StoredPeer {
    Endpoint endpoint;
    PeerBook::Memory memory{};
    bool is_proven = true;    // that it receives what is sent to it: FarPeer
};

struct StoredLink {
    UniqueFd wire{};                     // non-blocking; empty: it had none that can be stored
    ClockReading unread_since{};         // nothing was read of it since
    std::vector<std::uint8_t> rest{};    // what was read of a frame whose end had not come
    std::vector<StoredPeer> peers{};
};

/// Reading begins now. What waits on a wire that was another program's may have come at any time since that stopped to read.
inline void begin_arrival(Arrival& arrival, int wire, const StoredLink* stored, const ClockReading& now) noexcept {
    pollfd waiting{wire, POLLIN, 0};
    if (stored && ::poll(&waiting, 1, 0) > 0) arrival.unread_since(stored->unread_since);
    else arrival.found_empty(now);
}

}    // namespace anogate
