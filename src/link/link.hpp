// The interface between gateway and links, without Asio.
#pragma once
#include <gateway/arrival.hpp>
#include <gateway/channel.hpp>
#include <gateway/peers/peer_book.hpp>
#include <gateway/settings.hpp>
#include <link/link_error.hpp>
#include <link/stored_link.hpp>
#include <record/decoding.hpp>

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {

class Link;

/// The clock of the loop.
class LoopClock {
public:
    /// Reads the clock; once per batch is enough. The next frames received get this time.
    virtual TimePoint now() = 0;
    /// The same, to be called after a read; the result is used to find when the data arrived.
    virtual const StallDetector& turn() = 0;

protected:
    ~LoopClock() = default;
};

/// The other links of the gateway, as a link sees them. The defaults: there are none.
class OtherLinks {
public:
    /// Before open_channel() for a new peer of a listening link: if all channels are in use, one peer of a listening link frees its
    /// channel. It has sent no command and is not trusted. For an ordinary peer, it must also have been silent for too long.
    virtual void make_channel_free(PeerBook::Rank) {}
    /// The number of channels that open_channel() can still open.
    virtual std::size_t free_channels() const { return max_channels; }
    /// For a new channel whose peer is not trusted: it is not in the group of its link.
    virtual void leave_group(Channel&) {}
    /// Whether another link of the group of this channel is connected, and can carry its frames.
    virtual bool has_connected_mate(const Channel&) const { return false; }
    /// Whether a connected one of those links was passed a command after `since`.
    virtual bool has_newer_command_of_mate(const Channel&, TimePoint /*since*/) const { return false; }
    /// Whether one of our links, of any kind, is bound to this UDP port.
    virtual bool is_own_port(std::uint16_t) const { return false; }
    /// The channels of working links whose outboxes are not empty.
    virtual ChannelSet busy_channels() const { return {}; }

protected:
    ~OtherLinks() = default;
};

/// The gateway as its links see it. A link calls it from the loop only.
class LinkHost : public LoopClock, public OtherLinks {
public:
    /// A new channel of `link`; nullptr if all 64 are in use. Valid until close_channel(). Its outbox is closed at first.
    virtual Channel* open_channel(Link& link, std::string peer) = 0;
    /// `why` is for the log: what its peer did; may be empty.
    virtual void close_channel(Channel& channel, std::string_view why) = 0;

    /// To be called for each valid frame received by `channel`, after `arrived_at` is set.
    virtual void receive(Channel& channel, ano::FrameView frame) = 0;
    /// The batch of received frames ends: calls Link::flush() for every channel with new frames in its outbox.
    virtual void flush() = 0;

    /// The link works: opens the outboxes of all its channels.
    void link_up(Link& link) { changed(link, LinkEvent::up, {}); }
    /// The link does not work; `why` is the reason. Closes the outboxes. Repeated calls only change `why`.
    void link_down(Link& link, LinkError why) { changed(link, LinkEvent::down, std::move(why)); }
    /// The peer of `link` refuses datagrams, so that another link of its group should be used.
    void report_unreachable(Link& link) { changed(link, LinkEvent::unreachable, {}); }
    /// Link::trouble() of a link that may be up: it is new and should be logged.
    void report_trouble(Link& link, LinkError trouble) { changed(link, LinkEvent::trouble, std::move(trouble)); }

    /// The stored state of `link` from the previous run of the program; std::nullopt: none, or an earlier call returned it.
    virtual std::optional<StoredLink> claim_stored(const Link&) { return std::nullopt; }

protected:
    enum class LinkEvent : std::uint8_t { up, down, unreachable, trouble };
    virtual void changed(Link& link, LinkEvent event, LinkError why) = 0;
    ~LinkHost() = default;
};

/// Facts that only links of one kind have, for the status: {"port", 12333}.
using LinkFacts = std::vector<std::pair<std::string_view, std::variant<std::string, std::int64_t>>>;

/// Received data that belongs to no channel.
struct UnassignedTraffic {
    ReceiveCounters received;
    std::uint64_t v7_frames = 0;                 // frames of the previous protocol version
    std::uint64_t gateways = 0;                  // other gateways' listening ports that sent here
    std::uint64_t no_place = 0;                  // datagrams of unknown senders refused because max_peers is reached
    std::uint64_t no_memory = 0;                 // datagrams of unknown senders refused for lack of memory
    std::uint64_t outsiders = 0;                 // datagrams of unknown senders refused because they are outside `allow`
    const ano::FrameParser* parser = nullptr;    // of the data above; nullptr: none
    std::size_t without_frame = 0;               // connected clients that have sent no complete valid frame yet
    std::uint64_t handshakes = 0;                // recent connections dropped during their handshake in favour of others
};

/// One serial port, UDP socket, CAN interface and so on. Reads, writes and reports; it makes no routing decisions.
class Link {
public:
    Link(LinkId id, LinkSettings settings) : id_{id}, settings_{std::move(settings)} {}
    virtual ~Link() = default;
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;

    LinkId id() const noexcept { return id_; }
    const LinkSettings& settings() const noexcept { return settings_; }
    const std::string& name() const noexcept { return settings_.name; }

    /// Opens the link, and again whenever that fails or the connection is lost. Reports by link_up() and link_down().
    virtual void start() = 0;
    /// Stops reading; waiting frames may still be sent. The first half of stop().
    virtual void stop_reading() = 0;
    /// Closes for good, without blocking. Makes no call to the host afterwards.
    virtual void stop() = 0;
    /// Sends the frames in the outbox of `channel`: as many as can be written now, and the rest later.
    virtual void flush(Channel& channel) = 0;
    virtual LinkFacts facts() const { return {}; }
    /// A problem while the link is up, such as "the peer refuses"; empty: none.
    virtual LinkError trouble() const { return {}; }

    /// What the kind of link has beyond that: one of the classes below, or RawPort; nullptr: it has not.
    template <class T>
    T* as() noexcept {
        return dynamic_cast<T*>(this);
    }
    template <class T>
    const T* as() const noexcept {
        return dynamic_cast<const T*>(this);
    }

private:
    LinkId id_;
    LinkSettings settings_;
};

/// A link with a channel for each of several peers.
class PeerPlaces {
public:
    /// Closes the channel of one peer to free it for another link.
    virtual void forget_peer(ChannelId) = 0;
    /// The peer that frees its channel if all channels of the gateway are in use, see LinkHost::make_channel_free(): the longest
    /// silent one. std::nullopt: none.
    virtual std::optional<ChannelId> peer_to_replace(PeerBook::Rank, TimePoint) const = 0;
    /// Since when the peer of the channel only listens: a host that sent a single datagram. std::nullopt: it is none.
    virtual std::optional<TimePoint> listening_since(ChannelId) const { return std::nullopt; }
    /// The time since when data waits without any acknowledgement of the peer; std::nullopt: the link does not know.
    virtual std::optional<std::chrono::milliseconds> unacknowledged_for(ChannelId) const { return std::nullopt; }

protected:
    ~PeerPlaces() = default;
};

/// A link that receives data which belongs to no channel.
class UnassignedReceiver {
public:
    virtual UnassignedTraffic unassigned_traffic() const = 0;

protected:
    ~UnassignedReceiver() = default;
};

/// A link that knows what the kernel has not sent yet.
class KernelQueue {
public:
    /// Bytes in the kernel that are not on the wire yet, which Link::stop() would lose.
    virtual std::size_t unsent() const = 0;

protected:
    ~KernelQueue() = default;
};

/// A link with which the next run of the program can continue.
class StorableLink {
public:
    /// The open descriptor; -1: the next run can't use it.
    virtual int storable_wire() const = 0;
    virtual std::vector<StoredPeer> peers() const { return {}; }

protected:
    ~StorableLink() = default;
};

/// A link that is bound to a UDP port.
class LocalPort {
public:
    /// 0: none at present.
    virtual std::uint16_t local_port() const = 0;

protected:
    ~LocalPort() = default;
};

/// A recording as a link.
class PlayedRecording {
public:
    /// Whether it is at its end, so that nothing more will be received.
    virtual bool is_over() const = 0;
    /// The decoding of its present frames; nullptr: not known yet.
    virtual DecodingPtr decoding() const = 0;

protected:
    ~PlayedRecording() = default;
};

}    // namespace anogate
