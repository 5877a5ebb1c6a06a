// The counters, with the names used in every output. A new counter is a field and a row here.
#pragma once
#include <ano/parser.hpp>

#include <cstdint>
#include <string_view>

namespace anogate {

/// Counts what a channel received.
struct ReceiveCounters {
    std::uint64_t frames_in{};        // valid frames
    std::uint64_t bytes_in{};         // all bytes, valid or not
    std::uint64_t bad_check{};        // candidates with a wrong checksum
    std::uint64_t bad_length{};       // candidates longer than the link's max_data
    std::uint64_t skipped_bytes{};    // bytes outside of valid frames
    std::uint64_t expired{};          // candidates that were not completed in time
    std::uint64_t denied_in{};        // refused by a filter or by `allow`
    std::uint64_t inhibited{};        // blocked by an inhibit switch
    std::uint64_t looped{};           // received again through a loop
    std::uint64_t duplicate{};        // already received on another link of the group
    std::uint64_t no_route{};         // valid frames without a receiver
    std::uint64_t over_share{};       // datagrams of a peer that sent more than could be read in its share of the time
    std::uint64_t suspended{};        // refused for a second after a question of a listening gateway from their source
};

/// Counts what was offered to a channel. frames_out + every cause + the waiting frames = offered.
struct SendCounters {
    std::uint64_t frames_out{};
    std::uint64_t bytes_out{};
    std::uint64_t empty_out{};      // of frames_out, those with LEN 0: older devices lose such a frame and the next one
    std::uint64_t flush_bytes{};    // zero bytes outside of frames, see Outbox::flush_parser()
    std::uint64_t superseded{};     // replaced by a newer one of its kind
    std::uint64_t queue_full{};     // dropped for newer frames
    std::uint64_t stale{};          // waited longer than its age limit
    std::uint64_t limited{};        // above the rate limit of its id
    std::uint64_t denied_out{};     // refused by a filter or by the rules of V7, or because the link is in exclusive use
    std::uint64_t link_down{};      // the link was down, or went down
    std::uint64_t too_big{};        // more DATA than the link supports
    std::uint64_t send_failed{};    // refused by the operating system
    std::uint64_t held_back{};      // the peer is outside of the own networks and has not yet shown that it receives
    std::uint64_t offered{};        // every frame that was to be sent on this channel
};

/// The counter for the reason why a received frame, or a frame to be sent, was dropped.
using ReceiveCause = std::uint64_t ReceiveCounters::*;
using SendCause = std::uint64_t SendCounters::*;

/// Counters of the tunnel: sent and received datagrams and frames, and refusals by cause.
struct TunnelCounters {
    std::uint64_t out{};          // datagrams sent for tunnel frames of devices
    std::uint64_t in{};           // datagrams from the network that were at least partly accepted
    std::uint64_t unwrapped{};    // tunnel frames from the network that were opened
    std::uint64_t wrapped{};      // tunnel frames made for devices
    std::uint64_t tunnel_malformed{};
    std::uint64_t tunnel_bad_inner{};
    std::uint64_t tunnel_nested{};
    std::uint64_t tunnel_not_allowed{};
    std::uint64_t tunnel_own_port{};
    std::uint64_t tunnel_other_ip{};
    std::uint64_t tunnel_other_network{};
    std::uint64_t tunnel_too_big{};
    std::uint64_t tunnel_no_way{};
    std::uint64_t tunnel_down{};
    std::uint64_t tunnel_send_failed{};
};

enum class Counts : std::uint8_t {
    traffic,    // sent and received, or damaged
    losses,     // refused before it was a frame of a channel
    drops,      // complete frames that were not forwarded
};

template <class Counters>
struct CounterRow {
    std::string_view name;
    std::uint64_t Counters::*value;
    std::string_view help;
    Counts counts = Counts::drops;
};

inline constexpr CounterRow<ReceiveCounters> receive_counters[] = {
    {"frames_in", &ReceiveCounters::frames_in, "good frames received", Counts::traffic},
    {"bytes_in", &ReceiveCounters::bytes_in, "bytes received", Counts::traffic},
    {"bad_check", &ReceiveCounters::bad_check, "frames refused because a check byte does not hold", Counts::traffic},
    {"bad_length", &ReceiveCounters::bad_length, "frames refused because LEN is above max_data", Counts::traffic},
    {"skipped_bytes", &ReceiveCounters::skipped_bytes, "received bytes that belong to no good frame", Counts::traffic},
    {"expired", &ReceiveCounters::expired, "frames whose end never came", Counts::traffic},
    {"denied_in", &ReceiveCounters::denied_in, "received, refused by a filter or by allow"},
    {"inhibited", &ReceiveCounters::inhibited, "received, kept off by an inhibit switch"},
    {"looped", &ReceiveCounters::looped, "frames that went round and came back"},
    {"duplicate", &ReceiveCounters::duplicate, "copies that came by another link of the group already"},
    {"no_route", &ReceiveCounters::no_route, "good frames that had no taker"},
    {"over_share", &ReceiveCounters::over_share, "datagrams dropped because their peer sent more than its share", Counts::losses},
    {"suspended", &ReceiveCounters::suspended, "frames refused for a second because their peer asked as a listening gateway does",
     Counts::losses},
};

inline constexpr CounterRow<SendCounters> send_counters[] = {
    {"frames_out", &SendCounters::frames_out, "frames sent", Counts::traffic},
    {"bytes_out", &SendCounters::bytes_out, "bytes of the frames sent", Counts::traffic},
    {"empty_out", &SendCounters::empty_out, "frames sent that have no DATA", Counts::traffic},
    {"flush_bytes", &SendCounters::flush_bytes, "zero bytes sent to a device that may wait inside a damaged frame",
     Counts::traffic},
    {"superseded", &SendCounters::superseded, "replaced by a newer frame while waiting"},
    {"queue_full", &SendCounters::queue_full, "dropped because the queue was full"},
    {"stale", &SendCounters::stale, "dropped because they had waited too long"},
    {"limited", &SendCounters::limited, "dropped by a rate limit"},
    {"denied_out", &SendCounters::denied_out,
     "refused by a filter of the link or the rules of V7, or a terminal uses the link exclusively"},
    {"link_down", &SendCounters::link_down, "not sent, the link was down"},
    {"too_big", &SendCounters::too_big, "not sent, more DATA than the link carries"},
    {"send_failed", &SendCounters::send_failed, "not sent, refused by the system"},
    {"held_back", &SendCounters::held_back, "not sent to a peer outside our networks that has not answered yet"},
};

inline constexpr CounterRow<TunnelCounters> tunnel_counters[] = {
    {"out", &TunnelCounters::out, "datagrams sent for tunnel frames of devices"},
    {"in", &TunnelCounters::in, "datagrams at the tunnel port that brought something"},
    {"unwrapped", &TunnelCounters::unwrapped, "tunnel frames from the network that were opened"},
    {"wrapped", &TunnelCounters::wrapped, "tunnel frames made for devices"},
    {"tunnel_malformed", &TunnelCounters::tunnel_malformed, "tunnel frames too short for their addresses"},
    {"tunnel_bad_inner", &TunnelCounters::tunnel_bad_inner, "tunnel frames with bytes that are no whole good frame"},
    {"tunnel_nested", &TunnelCounters::tunnel_nested,
     "tunnel frames out of a tunnel frame that were to leave by the tunnel again"},
    {"tunnel_not_allowed", &TunnelCounters::tunnel_not_allowed, "destinations and senders outside allow"},
    {"tunnel_own_port", &TunnelCounters::tunnel_own_port, "datagrams for a port, or from the port, of the gateway itself"},
    {"tunnel_other_ip", &TunnelCounters::tunnel_other_ip, "tunnel frames from the network for another ip: no relay"},
    {"tunnel_other_network", &TunnelCounters::tunnel_other_network, "frames whose sender 0xB2 can't name"},
    {"tunnel_too_big", &TunnelCounters::tunnel_too_big, "more than a datagram, or a device's max_data, can hold"},
    {"tunnel_no_way", &TunnelCounters::tunnel_no_way, "no address of ours to name: no way leads there"},
    {"tunnel_down", &TunnelCounters::tunnel_down, "datagrams not sent, the tunnel port was not open"},
    {"tunnel_send_failed", &TunnelCounters::tunnel_send_failed, "datagrams not sent, refused by the system"},
};

/// Adds every counter of `b` to `a`; `offered` too.
constexpr void add(ReceiveCounters& a, const ReceiveCounters& b) noexcept {
    for (const auto& row : receive_counters) a.*row.value += b.*row.value;
}
constexpr void add(SendCounters& a, const SendCounters& b) noexcept {
    for (const auto& row : send_counters) a.*row.value += b.*row.value;
    a.offered += b.offered;
}

constexpr void add(ReceiveCounters& a, const ano::ParserCounters& b) noexcept {
    a.frames_in += b.frames_in;
    a.bytes_in += b.bytes_in;
    a.bad_check += b.bad_check;
    a.bad_length += b.bad_length;
    a.skipped_bytes += b.skipped_bytes;
    a.expired += b.expired;
}

constexpr std::uint64_t sum_of_losses(const auto& counters, const auto& table) noexcept {
    std::uint64_t sum = 0;
    for (const auto& row : table) sum += row.counts == Counts::traffic ? 0 : counters.*row.value;
    return sum;
}
constexpr std::uint64_t losses(const ReceiveCounters& c) noexcept { return sum_of_losses(c, receive_counters); }
constexpr std::uint64_t losses(const SendCounters& c) noexcept { return sum_of_losses(c, send_counters); }

/// Offered frames that were neither sent nor dropped: the waiting ones.
constexpr std::uint64_t unaccounted(const SendCounters& c) noexcept { return c.offered - c.frames_out - losses(c); }

}    // namespace anogate
