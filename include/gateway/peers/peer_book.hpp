// Which senders are accepted as peers of a listening socket, and for how long.
//
// Flow:    book.place_for(endpoint, now)           // an unknown sender: whether there is room, and which peer it replaces
//          book.add(id, endpoint, near, now)       // it is a peer now
//          book.came(id)                           // each of its datagrams except the first
//          book.heard(id, source, now)             // each of its valid frames
//          book.refused(id, now)                   // the network reports that the port is closed
//          for (id : book.overdue(now)) remove the peer, book.remove(id)
//          check again at book.next_look(now)
#pragma once
#include <ano/time.hpp>
#include <gateway/ids.hpp>
#include <gateway/ip.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace anogate {

using ano::Duration;
using ano::TimePoint;

/// Uses no sockets, and channels only by their numbers. Constant time per frame; no allocation.
class PeerBook {
public:
    struct Options {
        Duration timeout = std::chrono::seconds{60};    // a peer is removed after this silence, unless it only listens
        std::size_t max_peers = max_channels;
        std::size_t max_of_address = max_channels;    // loopback excepted
        std::size_t kept = 0;                         // places reserved for hosts that send commands, and for trusted ones
        std::size_t kept_for_trusted = 0;             // of those, the ones reserved for trusted ones
        /// Of TCP: an overdue peer is replaced only when its place is needed. For ordinary peers, a /64 of IPv6 counts as one
        /// address, since one computer can use all of it.
        bool has_connections = false;
        /// A random number: which senders share a row of rejected senders can't be predicted.
        std::uint64_t seed = 0;
    };
    /// The rank of a peer or an unknown sender, by its address and its frames.
    enum class Rank : std::uint8_t {
        ordinary,    // it only receives, asks, or sends unrequested frames
        commands,    // a host that has sent a command
        trusted,     // a member of a trusted network
    };

    /// A host in our own networks may only receive for this time, without sending.
    static constexpr Duration listener_stays = std::chrono::hours{1};
    /// A peer in our own networks that sent a single datagram is removed after this time, because its source may be forged. A
    /// host stays, since some hosts only receive. After this time at most two of them stay per address, and
    /// max_listeners of those that sent within one exchange in all: trusted ones before those that command, and these before others.
    /// Loopback addresses can't be forged.
    static constexpr Duration once_stays = std::chrono::seconds{10};
    static constexpr std::size_t max_listeners = 8;
    /// Two silent hosts stay per address: a program that restarts has another port, and frames to the old port are lost.
    /// A peer that sent a single datagram is removed after one refusal. Another peer is removed after this number of refusals
    /// without a frame from it in between, if the first and the last are at least `refused_for` apart.
    static constexpr std::uint32_t enough_refusals = 3;
    static constexpr Duration refused_for = std::chrono::seconds{5};

    /// Hosts that send commands replace each other once in this time on average, and turns_at_once times without a pause, so that
    /// a flood of such hosts causes little work, but no command is refused because others arrived at the same time.
    static constexpr Duration turn = std::chrono::microseconds{500};
    static constexpr int turns_at_once = 32;
    /// Frames within this time belong to one exchange.
    static constexpr Duration exchange = std::chrono::seconds{1};
    /// A device that sent within this time loses its channel to no peer of another link.
    static constexpr Duration device_is_active = std::chrono::seconds{3};

    explicit PeerBook(const Options& options) : options_{options} {}

    struct Place {
        bool free = false;
        std::optional<ChannelId> evicted;    // the peer that must be closed first
    };
    /// Whether an unknown sender may become a peer.
    /// - One that sent once does not replace a peer that was received within the timeout or sent more than once.
    /// - One that sends again, in a later exchange, replaces a silent peer, or one that did not send again and either is from an
    ///   address that keeps at least as many places as the address of the sender would have, or was silent for an exchange and is
    ///   no host that may listen.
    /// - If its address has max_of_address places, it replaces a peer of that address: also one that is silent for once_stays, no
    ///   host that may listen, and never commanded, such as the former port of a device that restarted. The last host of an address
    ///   that commanded leaves only for one that commands.
    /// - Programs of this machine replace each other, but one that sent once does not replace one that sent again.
    /// - Of several, one that sent once leaves before one that sent again, and of these the longest silent.
    /// - With connections, it replaces an overdue peer, and no trusted one unless it is trusted itself.
    /// - Peers of a lower rank do not use places that are reserved for a higher rank.
    /// - If places are reserved, a host that sends a command gets one, unless all turns are used. Of the two peers that sent
    ///   commands and joined last, it replaces the one that commands less often (the time between its last two commands, or since
    ///   the last, is longer), else the newest. Many such hosts take turns, one that commands more often stays, as do older ones.
    /// - If places are reserved, one of max_of_address is too, and if none is free a host that sends a command replaces one of its
    ///   address that does, in the same way.
    /// `commands`: it sends a command, which Rank::commands implies.
    Place place_for(const Endpoint& stranger, TimePoint now, Rank rank = Rank::ordinary, bool commands = false);

    /// `near`: it is in a network of our interfaces. It counts as received at `now`, since its first frame may be reported a
    /// little later.
    void add(ChannelId id, const Endpoint& endpoint, bool near, TimePoint now, Rank rank = Rank::ordinary);
    /// Another datagram of the peer was received.
    void came(ChannelId id) noexcept { peer(id).once = false; }
    /// The peer is a host and sent a command. Several at the same time count as one.
    void commanded(ChannelId id, TimePoint now) noexcept;
    Rank rank(ChannelId id) const noexcept { return peer(id).rank; }
    void remove(ChannelId id) noexcept;
    void clear() { used_.clear(); }

    void heard(ChannelId id, std::uint8_t source, TimePoint now) noexcept;
    /// The state of a peer besides its endpoint, for the next run of the program, which continues with its socket.
    struct Memory {
        TimePoint heard_at{};
        bool is_host = false;
        bool has_returned = false;
        bool once = false;
        bool commands = false;
    };
    Memory memory(ChannelId id) const noexcept;
    /// Restores the state of a peer that was just added.
    void remember(ChannelId id, const Memory& memory) noexcept;

    /// ICMP reported a closed port. Returns whether the peer is overdue now.
    bool refused(ChannelId id, TimePoint now) noexcept;

    /// The peer that frees its channel for a peer of rank `to` on another link, see LinkHost::make_channel_free(): the longest silent
    /// ordinary one, never a device that is active.
    std::optional<ChannelId> longest_silent(Rank to, TimePoint now) const noexcept;
    /// The peers to be removed now.
    ChannelSet overdue(TimePoint now) const noexcept;
    /// When a peer may be overdue next, if no frame is received until then; TimePoint::max(): never.
    TimePoint next_look(TimePoint now) const noexcept;

    ChannelSet peers() const noexcept { return used_; }
    /// The time since which a host of our networks that sent a single datagram only receives; std::nullopt: it is none.
    std::optional<TimePoint> listening_since(ChannelId id) const noexcept;

private:
    struct Peer {
        Endpoint endpoint;
        bool near = false;
        bool is_host = false;    // it sent a frame of a host
        bool once = true;        // it sent a single datagram
        Rank rank = Rank::ordinary;
        TimePoint heard_at{};
        TimePoint exchange_began{};    // when it started
        bool has_returned = false;     // more than one exchange
        std::uint32_t refusals = 0;    // since its last frame
        TimePoint first_refused_at{};
        bool is_gone = false;                            // concluded from refusals
        TimePoint commanded_at{}, commanded_before{};    // its last command and the one before
    };

    // An unknown sender for which there was no free place.
    struct RejectedSender {
        Endpoint endpoint;
        TimePoint first{};
        TimePoint last{};
        bool has_returned() const noexcept { return last - first >= exchange; }
    };
    static constexpr std::size_t max_rejected = 1024;
    static constexpr Duration kept_row = std::chrono::milliseconds{250};    // four frames a second hold it

    // A host that sent commands and lost its place.
    struct Displaced {
        Endpoint endpoint;
        TimePoint commanded_at{};
    };
    static constexpr std::size_t max_displaced = 64;

    std::size_t places_of(const IpAddress& address, Rank rank) const noexcept;
    bool may_leave_for_party(const Peer& p, const IpAddress& address, Rank rank) const noexcept;
    bool is_same_party(const IpAddress& a, const IpAddress& b, Rank rank) const noexcept;
    bool keeps_retrying(const Endpoint& stranger, TimePoint now) noexcept;
    RejectedSender& row_of(const Endpoint& stranger) noexcept;
    const Peer& peer(ChannelId id) const noexcept { return peers_[index(id)]; }
    Peer& peer(ChannelId id) noexcept { return peers_[index(id)]; }
    bool has_free_place(Rank rank) const noexcept;
    bool may_be_evicted(const Peer& p, Rank to) const noexcept;
    static bool leaves_before(const Peer& a, const Peer& b) noexcept;
    static bool has_commanded(const Peer& p) noexcept { return p.rank == Rank::commands || p.commanded_at != TimePoint{}; }
    std::size_t kept_of_address(const IpAddress& address) const noexcept;
    /// `of`: of this address; nullptr: of those that are not trusted.
    std::optional<ChannelId> replaced_by_command(Rank rank, const IpAddress* of, TimePoint now) const noexcept;
    bool takes_turn(TimePoint now) noexcept;
    void remember_displaced(const Peer& p) noexcept;
    std::size_t count(Rank at_least) const noexcept;
    bool may_listen(const Peer& p) const noexcept { return p.near && p.is_host; }
    bool is_silent(const Peer& p, TimePoint now) const noexcept { return now - p.heard_at >= options_.timeout; }
    // How long it may be silent before it is removed, or counts as one that only receives.
    Duration patience(const Peer& p) const noexcept;
    bool listens(const Peer& p, TimePoint now) const noexcept {
        return !p.is_gone && may_listen(p) && now - p.heard_at >= patience(p);
    }
    bool exceeds_address(ChannelId id, TimePoint now) const noexcept;
    bool exceeds_listeners(ChannelId id, TimePoint now) const noexcept;
    bool is_overdue(ChannelId id, TimePoint now) const noexcept;
    TimePoint max_stay(const Peer& p) const noexcept;

    Options options_;
    std::array<Peer, max_channels> peers_;
    ChannelSet used_;
    std::array<RejectedSender, max_rejected> rejected_;
    std::array<Displaced, max_displaced> displaced_;
    TimePoint turns_used_until_{};
};

/// Whether a source address can be a peer's: not broadcast, multicast or 0.0.0.0, and not port 0. `own`: our networks.
bool can_be_peer(const Endpoint& sender, const std::vector<Network>& own) noexcept;

}    // namespace anogate
