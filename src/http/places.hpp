// Who has a place at the server, and who leaves for another.
#pragma once
#include <ano/time.hpp>
#include <http/doors/door.hpp>

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

/// The connections of a party are counted together: those of a user of this machine, or of a client of the network.
struct Party {
    std::uint32_t user = 0;      // unknown_user: the network
    std::uint64_t client = 0;    // of the network: which client
    bool operator==(const Party&) const = default;
};
Party party_of(std::uint32_t user, const Door& door);

/// One client that has a place.
struct Visitor {
    Party party{};
    Asking asking = Asking::nothing;
    ano::TimePoint since{};         // when it connected or last made progress
    std::optional<Access> may{};    // std::nullopt: nothing was judged yet
    bool by_address = false;        // `may`, because its client controlled before; it has shown nothing itself
    bool streams = false;           // its answer is a stream or a WebSocket, which stays
    bool lasts = false;             // its answer, no stream, has taken more than a moment
};

/// All places of a door are taken by `visitors`, and somebody connects. Returns whose place he gets; std::nullopt: nobody's yet, since all
/// are requests of those who may control, which will soon be answered.
///
/// Who has no complete request leaves first: first those of the party with most of them; clients that may control come last, and of those the
/// ones last that have shown a token. Of a party's, there are three sorts: idle, with half a request, not heard yet and connected before
/// `connected_before`. One of the sort with most clients leaves, so that a crowd of one sort does not displace another; within it, the one
/// that was silent longest. If all have complete requests, one leaves that
/// may not control: of the party with most of those, the oldest; and if there is none, one whose answer lasts.
std::optional<std::size_t> gives_way(std::span<const Visitor> visitors, ano::TimePoint connected_before = ano::TimePoint::max());

/// Whether there is a place, and who leaves it.
struct PlaceFor {
    bool is_free = false;
    std::optional<std::size_t> leaves{};
};

/// For a request of one of `visitors` that was just judged. One place in eight is kept for who may control. If the others are all taken by complete requests, a party with fewer than another gets one of
/// the party with most of them: the oldest.
PlaceFor request_place(std::span<const Visitor> visitors, std::size_t places, const Party& party, Access access);

/// For a stream or WebSocket. `streams` places are for streams and WebSockets, so that others find one however many stay; a quarter of those is kept for clients
/// that may control. If none is free, a client that controls gets that of one that only views, else a client that has fewer of its right than
/// another gets one of the client with most of them: the oldest.
PlaceFor stream_place(std::span<const Visitor> visitors, std::size_t streams, const Party& party, Access access);

/// The stream that has sent nothing for the longest time; std::nullopt: there is none.
std::optional<std::size_t> oldest_stream(std::span<const Visitor> visitors);

}    // namespace anogate::http
