// Decides which clients may use the limited connections of the server, and which connection is closed for another one.
#pragma once
#include <ano/time.hpp>
#include <http/listeners/connection_info.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace anogate::http {

/// How much of a request a client has sent.
enum class Asking : std::uint8_t {
    nothing,    // idle: the next request may arrive at any time
    half,       // an incomplete request
    unheard,    // just connected: its request may be on the way
    whole,      // a complete request, which is being answered
};

/// The connections of a party are counted together. A party is a user of this machine or a client of the network.
struct ClientId {
    std::uint32_t user = 0;      // unknown_user: the network
    std::uint64_t client = 0;    // of the network: which client
    bool operator==(const ClientId&) const = default;
};
ClientId client_id_of(std::uint32_t user, const ConnectionInfo& connection_info);

/// One client that has a place.
struct ClientConnection {
    ClientId client_id{};
    Asking asking = Asking::nothing;
    ano::TimePoint since{};         // when it connected or last made progress
    std::optional<Access> may{};    // std::nullopt: no request was judged yet
    bool by_address = false;        // `may` is assumed since the party controlled before; this connection has shown no token
    bool streams = false;           // its response is a stream or a WebSocket, which has no end
    bool lasts = false;             // its response, no stream, has taken longer than SessionLimits::stalled_after
};

/// For a new client when `connections` take all places of a listener: the index of the connection to close for it. std::nullopt: none
/// yet, since all are requests of clients that may control, which will soon be answered.
///
/// Connections without a complete request are closed first. The order among them: those that may not control, those that are
/// assumed to control (`by_address`), those that have shown a token. Of these, the party with most connections loses one. Its
/// connections are of three sorts: idle; with an incomplete request; silent since they connected, before `connected_before`. One
/// of the sort with most connections is closed, so that many of one sort do not displace another: the one that was silent
/// longest. If all connections have complete requests, one that may not control is closed: the oldest of the party with most of
/// those. If there is none, one whose response lasts is closed.
std::optional<std::size_t> next_evicted(std::span<const ClientConnection> connections,
                                        ano::TimePoint connected_before = ano::TimePoint::max());

/// Whether there is a place, and the index of the visitor whose connection is closed for it, if any.
struct PlaceFor {
    bool is_free = false;
    std::optional<std::size_t> leaves{};
};

/// For a request of one of `connections` that was just judged. One place in eight is reserved for clients that may control. If
/// complete requests take all the others, a party that has fewer than another gets the oldest place of the party with most of
/// them.
PlaceFor request_place(std::span<const ClientConnection> connections, std::size_t places, const ClientId& client_id,
                       Access access);

/// For a stream or WebSocket. At most `streams` places are used for streams and WebSockets, so that other requests always find
/// one; a quarter of them is reserved for clients that may control. If none is free, a client that controls gets the place of a
/// client that only views. Otherwise a party that has fewer than another with the same access gets the oldest place of the party
/// with most of them.
PlaceFor stream_place(std::span<const ClientConnection> connections, std::size_t streams, const ClientId& client_id,
                      Access access);

/// The stream that has sent nothing for the longest time; std::nullopt: there is none.
std::optional<std::size_t> oldest_stream(std::span<const ClientConnection> connections);

}    // namespace anogate::http
