// What is wrong with a link, and what to do, told from its counters. README, "Troubleshooting".
#pragma once
#include <ano/time.hpp>
#include <gateway/counters.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {

/// One sentence for people, and what it is made of for those who say it in another language.
struct Hint {
    using Value = std::variant<std::int64_t, bool, std::string>;

    std::string_view id{};    // snake_case, stays as it is; empty: there is nothing to say
    std::string text{};
    std::vector<std::pair<std::string_view, Value>> args{};    // what the text has beside its words, by name
};

/// A source that is heard on this link and on a link of another group, or from two peers of this link.
enum class SharedSource : std::uint8_t {
    none,
    one_device,     // on two cables, as far as can be told
    two_devices,    // with the same id
    two_peers,      // of this link
};

/// The words for what depends on the kind of a link, with an id of their own.
struct LinkHints {
    struct Words {
        std::string_view id{}, text{};
    };
    Words nothing_yet{};                // nothing was received; empty: that is as usual as not
    bool may_wait_for_hello = false;    // who is there may speak only when spoken to
    Words no_frames{"no_frames", "bytes but no frames: is the sender speaking V8?"};
    Words no_frames_any_more{"no_frames_any_more", ": is the sender still speaking V8?"};
};

/// What is known of a link at a moment.
struct LinkFigures {
    LinkHints words;
    bool up = false;
    bool is_over = false;          // a recording, and at its end
    bool listens = false;          // has a channel a peer, and waits for them
    bool waits_to_hear = false;    // never speaks first, and could be told to
    bool for_hosts = false;        // a route leads hosts' frames here: who is there may only listen
    std::size_t channels = 0;
    ReceiveCounters received;    // all channels, and what belongs to none
    SendCounters sent;
    std::uint64_t came_stale = 0;    // of `sent.stale`: had waited elsewhere, while the gateway stood still
    std::uint64_t v7_frames = 0;
    std::string_view ring_out, ring_back;    // names of links: what goes out by one comes back by the other; empty: no ring
    bool ring_is_certain = true;             // or a device on two links
    std::uint64_t gateways = 0;              // other gateways' listening ports that were refused
    std::uint64_t no_place = 0;              // datagrams of strangers that were refused for want of a place
    ano::Duration up_for{};
    std::optional<ano::Duration> silent_for;     // since the last good frame; nothing: there was none
    std::uint64_t skipped_since = 0;             // bytes of no frame, since then
    std::optional<ano::Duration> bytes_ago;      // since the last byte; nothing: there was none
    std::optional<ano::Duration> untaken_for;    // frames to hosts have had no taker; nothing: none come, or they have
    std::string_view hosts_link;                 // where hosts were heard last, when all such links are down; empty: not so
    SharedSource shared = SharedSource::none;
    std::uint8_t hidden = 0;    // a device here whose address is the port id of another link; 0: none
};

/// At most one, the most important one; empty when all is well.
Hint find_hint(const LinkFigures& link);
inline std::string hint(const LinkFigures& link) { return find_hint(link).text; }
/// The same without hints of silence, which is normal now and then on a good link, and without times, which change with every look.
std::string hint_of_trouble(const LinkFigures& link);

}    // namespace anogate
