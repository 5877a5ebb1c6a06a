// What the Forwarder must know of a link, and what it counts for it.
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
#include <gateway/untaken.hpp>

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
    bool sends_empty = true;             // whether frames without DATA leave by it
    bool takes_few_questions = false;    // of its devices: further questions wait before the outbox
    bool takes_probes = true;            // whether the LoopGuard may send probes by it
    std::vector<AliasRule> aliases;      // of its devices; each `as` is pinned to the link
    std::uint8_t present_as = 0;         // the address under which its devices see every host; 0: the host's own
    ano::Duration hello{};               // interval between hellos; zero: never
    ano::EulerSigns attitude{};          // of its devices
};

/// An address that was noted, for a hint.
struct NotedAddress {
    static constexpr ano::Duration shown_for = std::chrono::seconds{60};

    std::uint8_t address = 0;
    std::optional<ano::TimePoint> at{};    // std::nullopt: never
    std::optional<std::uint8_t> lately(ano::TimePoint now) const noexcept {
        return at && now - *at < shown_for ? std::optional{address} : std::nullopt;
    }
};

/// Counters of a link, in addition to those of its channels.
struct LinkTraffic {
    ChannelSet channels;                // the open ones
    ReceiveCounters gone_received;      // of closed channels
    SendCounters gone_sent;             // of closed channels, and of frames for a link that had no channel
    std::uint64_t came_stale = 0;       // of those counted `stale`: the ones that were stale before they were queued here
    Untaken untaken;                    // of frames that came for hosts
    NotedAddress not_sent;              // of a device: a frame that came by this link and acts on it went nowhere
    NotedAddress nobody;                // 0x00 or 0xFF, from where a device sends
    NotedAddress answers_for_others;    // the device, alone here, that answered for an address not its own
    AttitudeWatch attitudes;            // of its devices
    std::bitset<256> replayed;          // addresses that sent in a recording; no frames are routed to them
};

}    // namespace anogate
