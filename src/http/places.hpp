// Which connection is closed for a new one when the server has no free place.
#pragma once
#include <ano/time.hpp>
#include <http/door.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace anogate::http {

/// How much of a request a client has sent.
enum class Asking : std::uint8_t {
    nothing,    // idle: the next request may come at any time
    half,       // the beginning of a request only
    unheard,    // just connected: its request may be on the way
    whole,      // a complete request, which is being answered
};

/// The connections of a party are counted together: each user of this machine is a party, and all clients from the network together
/// are one. Within that one, places are shared among its clients.
struct Party {
    std::uint32_t user = 0;      // unknown_user: the network
    std::uint64_t client = 0;    // of the network: which client
};
Party party_of(std::uint32_t user, const Door& door);

/// One client that has a place.
struct Visitor {
    Party party{};
    Asking asking = Asking::nothing;
    ano::TimePoint since{};         // when it connected or last made progress
    std::optional<Access> may{};    // what its last request was allowed; std::nullopt: none was judged yet
};

/// All places are taken by `visitors`, and a client of `party` connects. Returns the index of the visitor whose place it gets;
/// std::nullopt: it is refused.
///
/// Each party has the same share. A party with its full share gets a place only from itself; one with less gets a place of the party
/// that is furthest above its share. The order of giving way: first idle clients and those with half a request, of these two sorts
/// the one with more clients, so that a crowd of one sort does not displace the other; then clients not heard yet. Within a sort, the
/// one that was silent longest. A complete request gives way to a party below its share, never to its own party. `first` (root and
/// our own user) gets a place even if there are more parties than places.
///
/// Among clients of the network: a client without a complete request gives way to any other; first one of the client with most of
/// them. A complete request gives way to a client below its share and to one that has shown that it may control; the complete request
/// of a client that may control gives way to no client of the network.
std::optional<std::size_t> gives_way(std::span<const Visitor> visitors, const Party& party, bool first);

/// Whether the request of one of `visitors` with `access` may keep its place while it is answered. One place in eight is reserved for
/// clients that may control, so that they find a place however many clients only view. One more place is kept free for requests that
/// are not judged yet.
bool has_place(std::span<const Visitor> visitors, std::size_t places, Access access);

/// A client that controls has taken the last place: which viewing client must leave, so that the next one can connect. std::nullopt:
/// none.
std::optional<std::size_t> leaves_room(std::span<const Visitor> visitors, std::size_t places);

}    // namespace anogate::http
