// Derives from the counters of a link what is wrong with it, and what to do (tools/README.md, "Troubleshooting").
#pragma once
#include <ano/attitude.hpp>
#include <ano/parser.hpp>
#include <ano/time.hpp>
#include <gateway/counters.hpp>
#include <gateway/wrong_frames.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {

/// One sentence for people, and its parts for translations.
struct Hint {
    using Value = std::variant<std::int64_t, bool, std::string>;

    std::string_view id{};    // snake_case, never changed; empty: no hint
    std::string text{};
    std::vector<std::pair<std::string_view, Value>> args{};    // the variable parts of the text, by name
};

/// A source received on this link and on a link of another group, or from two peers of this link.
enum class SharedSource : std::uint8_t {
    none,
    one_device,       // connected by two cables, as far as is known
    two_devices,      // with the same id
    two_peers,        // of this link
    claims_pinned,    // another link claims an address that is pinned
    of_a_group,       // an untrusted peer of a link claims an address of the group of the link
};
/// What to do about it, for hints and for the log.
std::string_view advice_on(SharedSource shared);

/// The texts that depend on the kind of a link, each with its id.
struct LinkHints {
    struct Words {
        std::string_view id{}, text{};
    };
    Words nothing_yet{};                // nothing was received; empty: this is not unusual
    bool may_wait_for_hello = false;    // the other end may send only after it has received something
    Words no_frames{"no_frames", "data but no valid frames: does the sender use ANO V8?"};
    Words no_frames_any_more{"no_frames_any_more", ": does the sender still use ANO V8?"};
};

/// The state of a link at one moment.
struct LinkFigures {
    LinkHints words;
    bool up = false;
    bool is_over = false;             // a recording that is at its end
    bool listens = false;             // has a channel per peer, and waits for peers
    bool has_connections = false;     // its peers connect; otherwise they are known by their frames
    bool could_send_hello = false;    // sends no hello, but could be configured to
    bool for_hosts = false;           // of hosts only, by the received frames or by a route: the other end may only receive
    std::size_t channels = 0;
    ReceiveCounters received;    // of all channels, and bytes that belong to no channel
    SendCounters sent;
    std::uint64_t came_stale = 0;    // the part of `sent.stale` that became stale while the gateway stood still
    std::uint64_t v7_frames = 0;
    std::uint64_t long_images = 0;                 // ParserCounters
    std::size_t longest_image = 0;                 // FrameParser::longest_image()
    bool may_use_v7 = false;                       // it has the key `protocol`
    bool v7_loops = false, v7_commands = false;    // V7Counters::up_loop, up_command: lately
    std::string_view ring_out, ring_back;    // names of links: frames sent on the first return on the second; empty: no loop
    std::vector<std::uint8_t> skipped{};     // the last bytes outside of any frame, of one parser
    std::uint64_t gateways = 0;              // refused listening ports of other gateways
    std::uint64_t no_place = 0;              // datagrams of unknown senders, refused because all places were in use
    std::uint64_t no_memory = 0;             // the same, refused for lack of memory
    std::uint64_t outsiders = 0;             // the same, refused because the sender is outside `allow`
    bool is_exclusive = false;               // a terminal uses it exclusively: no frames are sent to it
    std::size_t without_frame = 0;           // connected clients that have sent no complete valid frame yet
    std::uint64_t handshakes = 0;            // connections closed lately for others, during their TLS handshake
    std::optional<std::uint64_t> frames_since_skipped;    // on the worst channel; std::nullopt: no byte was skipped
    ano::Duration up_for{};
    std::optional<ano::Duration> silent_for;         // since the last valid frame; std::nullopt: there was none
    std::uint64_t skipped_since = 0;                 // bytes outside of any frame, since then
    std::optional<ano::Duration> bytes_ago;          // since the last byte; std::nullopt: there was none
    std::optional<ano::Duration> undelivered_for;    // how long frames to hosts have had no receiver; std::nullopt: they have one
    std::string_view hosts_link;    // the link on which hosts were last received, if all such links are down; else
                                    // empty
    SharedSource shared = SharedSource::none;
    std::uint8_t shared_address = 0;                   // of that source; 0: not known
    std::optional<std::uint8_t> not_sent;              // a frame from here that acts on this device was not sent
    ToUtf8 to_utf8 = nullptr;                          // for texts that are displayed
    bool echoes = false;                               // sent frames are received again on it
    std::optional<std::uint8_t> answers_for_others;    // the device here that answers for addresses that are not its own
    std::optional<std::uint8_t> nobody;                // 0x00 or 0xFF, the source address of frames of a device here
    std::uint8_t contradictory = 0;                    // address of a device here, see AttitudeWatch; 0: none
    ano::EulerSigns attitude{};                        // the setting of the link
    std::uint8_t hidden = 0;    // address of a device here that is also the port id of another link; 0: none
};

/// Frames that act on the device `address` are not sent: its link is not known or, for all devices (0xFF), no link accepts
/// broadcasts.
Hint not_routed(std::uint8_t address);
/// Adds the last bytes skipped by `parser`, if there are any and no other parser added some before.
void add_skipped(LinkFigures& link, const ano::FrameParser& parser);

/// Of `control.http`, not of a link: it has lately closed waiting connections to make room for others.
Hint waiting_connections_closed();

/// The most important hint; empty when there is none.
Hint find_hint(const LinkFigures& link);
inline std::string hint(const LinkFigures& link) { return find_hint(link).text; }
/// The same without hints about silence, which may be normal on a working link, and without durations, which change with every
/// call.
std::string hint_of_trouble(const LinkFigures& link);

}    // namespace anogate
