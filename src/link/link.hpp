// What the gateway asks of a link, and what a link tells the gateway. No Asio here.
#pragma once
#include <gateway/arrival.hpp>
#include <gateway/channel.hpp>
#include <gateway/settings.hpp>
#include <link/link_error.hpp>
#include <link/stored_link.hpp>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {

class Link;

/// The gateway as its links see it. A link calls these from the loop only.
class LinkHost {
public:
    /// A channel of `link`, or nothing when all 64 are in use. It lives until close_channel(); its outbox starts closed.
    virtual Channel* open_channel(Link& link, std::string peer) = 0;
    virtual void close_channel(Channel& channel) = 0;

    /// A good frame came in by `channel`, whose `arrived_at` says when.
    virtual void receive(Channel& channel, ano::FrameView frame) = 0;
    /// The batch ends: every channel that was given frames is flushed, by Link::flush().
    virtual void flush() = 0;

    /// The wire is there: frames may leave. Opens the outbox of every channel the link has.
    virtual void link_up(Link& link) = 0;
    /// The wire is gone, `why` says it in a clause. Closes the outboxes. Repeated calls only change `why`.
    virtual void link_down(Link& link, LinkError why) = 0;

    /// What went out by `link` did not arrive: its peer refuses. Another link of its group may do better.
    virtual void report_unreachable(Link&) {}

    /// What the program that ran before left of `link`; nothing: nothing, or it was taken already.
    virtual std::optional<StoredLink> take_stored(const Link&) { return std::nullopt; }

    /// A link of ours, a udp: one as well, takes datagrams at this UDP port.
    virtual bool is_own_port(std::uint16_t) const { return false; }

    /// The channels whose wires are there and have not taken yet what waits for them.
    virtual ChannelSet busy_channels() const { return {}; }

    /// Reads the clock; once a batch is enough. What is received next carries this time.
    virtual TimePoint now() = 0;
    /// The same where something has been read: what tells when that had arrived.
    virtual const LoopWatch& turn() = 0;

protected:
    ~LinkHost() = default;
};

/// What only its kind knows of a link, for the status: {"port", 12333}.
using LinkFacts = std::vector<std::pair<std::string_view, std::variant<std::string, std::int64_t>>>;

/// What came in and belongs to no channel.
struct UnassignedTraffic {
    ReceiveCounters received;
    std::uint64_t v7_frames = 0;    // frames of the previous protocol version
    std::uint64_t gateways = 0;     // listening ports of other gateways that turned up as peers
    std::uint64_t no_place = 0;     // datagrams of strangers for whom no peer gave way
};

/// One serial port, one UDP socket, one CAN interface. Reads, writes and reports; decides nothing.
class Link {
public:
    Link(LinkId id, LinkSettings settings) : id_{id}, settings_{std::move(settings)} {}
    virtual ~Link() = default;
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;

    LinkId id() const noexcept { return id_; }
    const LinkSettings& settings() const noexcept { return settings_; }
    const std::string& name() const noexcept { return settings_.name; }

    /// Opens, now and again whenever that fails or the wire goes; says so by link_up() and link_down().
    virtual void start() = 0;
    /// Reads no more; what waits may still leave. The first half of stop().
    virtual void stop_reading() = 0;
    /// Closes for good, without blocking; no call to the host comes after it.
    virtual void stop() = 0;
    /// Frames wait in the outbox of `channel`: sends what the wire takes, and the rest when it takes more.
    virtual void flush(Channel& channel) = 0;
    /// Its channel goes, to make room for one of another link. Of a link that has one for each peer; else nothing is done.
    virtual void forget_peer(ChannelId) {}
    /// Bytes the kernel has taken and not yet put on the wire, where it can be known: stop() would lose them.
    virtual std::size_t unsent() const { return 0; }
    /// The UDP port it listens on; 0: none.
    virtual std::uint16_t local_port() const { return 0; }
    /// The open descriptor, where the program started next may go on with it; -1: none.
    virtual int storable_wire() const { return -1; }
    /// Who that program is to know.
    virtual std::vector<StoredPeer> peers() const { return {}; }
    virtual LinkFacts facts() const { return {}; }
    /// What goes wrong while it is up ("the peer refuses"); empty: nothing.
    virtual LinkError trouble() const { return {}; }
    /// Nothing more comes by it: a recording is at its end.
    virtual bool is_over() const { return false; }
    /// What was refused before it belonged to a channel.
    virtual UnassignedTraffic unassigned_traffic() const { return {}; }

private:
    LinkId id_;
    LinkSettings settings_;
};

}    // namespace anogate
