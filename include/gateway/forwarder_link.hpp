// What the Forwarder has to know of a link, and what it counts of it.
#pragma once
#include <ano/parser.hpp>
#include <ano/time.hpp>
#include <gateway/alias.hpp>
#include <gateway/counters.hpp>
#include <gateway/filter.hpp>
#include <gateway/ids.hpp>
#include <gateway/outbox.hpp>
#include <gateway/router.hpp>
#include <gateway/untaken.hpp>

#include <bitset>
#include <cstdint>
#include <vector>

namespace anogate {

struct ForwarderLink {
    Router::LinkRule route;
    ano::FrameParser::Options parser;    // of each of its channels
    Outbox::Options outbox;              // as well
    RuleSettings rules;
    bool sends_empty = true;             // frames without DATA leave by it
    bool takes_few_questions = false;    // its devices: one too many waits before the outbox
    bool takes_probes = true;            // RingWatch may ask by it
    std::vector<AliasRule> aliases;      // of its devices; each `as` is pinned to the link
    std::uint8_t present_as = 0;         // the address that every host has for its devices; 0: its own
    ano::Duration hello{};               // how often to speak first; zero: never
};

/// What became of the frames of a link, beside what its channels count.
struct LinkTraffic {
    ChannelSet channels;              // that are open
    ReceiveCounters gone_received;    // of channels that are no more
    SendCounters gone_sent;           // and of frames for a link that had no channel
    std::uint64_t came_stale = 0;     // of what is `stale`: was so when it was to be sent here
    Untaken untaken;                  // of what came for hosts
    std::bitset<256> replayed;        // addresses that spoke in a recording; nothing leads to them
};

}    // namespace anogate
