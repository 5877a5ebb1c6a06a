// The settings of a link for the Forwarder, and its counters.
#pragma once
#include <ano/parser.hpp>
#include <ano/time.hpp>
#include <gateway/alias.hpp>
#include <gateway/attitude_watch.hpp>
#include <gateway/counters.hpp>
#include <gateway/filter.hpp>
#include <gateway/ids.hpp>
#include <gateway/outbox.hpp>
#include <gateway/router.hpp>
#include <gateway/undelivered.hpp>

#include <bitset>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace anogate {

struct ForwarderLink {
    Router::LinkRule route;
    ano::FrameParser::Options parser;    // for each of its channels
    Outbox::Options outbox;              // for each of its channels
    RuleSettings rules;
    bool sends_empty = true;           // whether frames without DATA are sent on it
    bool limits_questions = false;     // by its devices: further questions wait before the outbox
    bool allows_probes = true;         // whether the LoopGuard may send probes on it
    std::vector<AliasRule> aliases;    // of its devices; each `as` is pinned to the link
    std::uint8_t present_as = 0;       // the address under which its devices see every host; 0: the host's own
    ano::Duration hello{};             // interval between hellos; zero: never
    ano::EulerSigns attitude{};        // of its devices
};

/// An address that is stored for a hint.
struct NotedAddress {
    static constexpr ano::Duration reported_for = std::chrono::seconds{60};

    std::uint8_t address = 0;
    std::optional<ano::TimePoint> at{};    // std::nullopt: never
    std::optional<std::uint8_t> lately(ano::TimePoint now) const noexcept {
        return at && now - *at < reported_for ? std::optional{address} : std::nullopt;
    }
};

/// Counters of a link, in addition to those of its channels.
struct LinkTraffic {
    ChannelSet channels;                // the open channels
    ReceiveCounters gone_received;      // of closed channels
    SendCounters gone_sent;             // of closed channels, and of frames for a link that had no channel
    std::uint64_t came_stale = 0;       // of those counted `stale`: frames that were stale before they were queued here
    Undelivered undelivered;            // of received frames for hosts
    NotedAddress not_sent;              // a device: a frame received here that acts on it was not sent
    NotedAddress nobody;                // 0x00 or 0xFF, the source address of frames of a device
    NotedAddress answers_for_others;    // the only device here; it answered for an address that is not its own
    AttitudeWatch attitudes;            // of its devices
    std::bitset<256> replayed;          // addresses that sent in a recording; no frames are routed to them
};

}    // namespace anogate
