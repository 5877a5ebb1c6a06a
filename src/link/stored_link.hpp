// What a link leaves to the link of the same name in the program that is started next: its open wire, and who was behind it.
#pragma once
#include <gateway/arrival.hpp>
#include <gateway/ip.hpp>
#include <gateway/peer_book.hpp>
#include <link/unique_fd.hpp>

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

}    // namespace anogate
