// The state that a link stores for the link of the same name in the next run of the program: its open descriptor and its peers.
#pragma once
#include <gateway/arrival.hpp>
#include <gateway/ip.hpp>
#include <gateway/peers/peer_book.hpp>
#include <sys/unique_fd.hpp>

#include <poll.h>

#include <cstdint>
#include <vector>

namespace anogate {

/// A peer of a listening socket.
struct StoredPeer {
    Endpoint endpoint;
    PeerBook::Memory memory{};
    bool is_proven = true;    // has shown that it receives, see FarPeer
};

struct StoredLink {
    UniqueFd wire{};                     // non-blocking; empty: none could be stored
    ClockReading unread_since{};         // time of the last read
    std::vector<std::uint8_t> rest{};    // the received bytes of an incomplete frame
    std::vector<StoredPeer> peers{};
};

/// Reading begins now. Data on a stored wire may have arrived at any time since the previous program's last read.
inline void begin_arrival(Arrival& arrival, int wire, const StoredLink* stored, const ClockReading& now) noexcept {
    pollfd waiting{wire, POLLIN, 0};
    if (stored && ::poll(&waiting, 1, 0) > 0) arrival.unread_since(stored->unread_since);
    else arrival.found_empty(now);
}

}    // namespace anogate
