// Who may be a peer of a listening socket, and for how long.
//
// Flow:    book.place_for(endpoint, now)           // a stranger: whether there is room, and which peer gives way
//          book.add(id, endpoint, near, now)       // it is a peer now
//          book.came(id)                           // every datagram of it but the first
//          book.heard(id, source, now)             // every good frame of it
//          book.refused(id, now)                   // the network says that nothing listens there
//          for (id : book.overdue(now)) forget it, book.remove(id)
//          look again at book.next_look(now)
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

/// Uses no sockets, and channels only by their numbers. Constant time a frame; no allocation.
class PeerBook {
public:
    struct Options {
        Duration timeout = std::chrono::seconds{60};    // a peer silent for so long is forgotten, unless it listens
        std::size_t max_peers = max_channels;
        std::size_t max_of_address = max_channels;    // loopback excepted
        std::size_t kept = 0;                         // places that only hosts that command, and trusted ones, may take
        std::size_t kept_for_trusted = 0;             // of those, the ones that only trusted ones may take
    };
    /// Who a peer or a stranger is, by its address and what it sent.
    enum class Rank : std::uint8_t {
        ordinary,    // it listens, asks, or sends what nobody asked for
        commands,    // a host that has sent a command
        trusted,     // a member of a trusted network
    };

    /// A host in our own networks may listen this long without sending anything.
    static constexpr Duration listener_stays = std::chrono::hours{1};
    /// A peer in our own networks that sent a single datagram is forgotten after this time: its source may be forged. A host stays, since
    /// some only listen, but after this time at most max_silent_of_address of an address and max_listeners in all. Nobody forges
    /// loopback addresses.
    static constexpr Duration once_stays = std::chrono::seconds{10};
    static constexpr std::size_t max_listeners = 8;
    /// Maximum of silent hosts of one address: a program that starts again has another port, and frames to the old port are lost.
    static constexpr std::size_t max_silent_of_address = 2;
    /// A peer that sent a single datagram is gone after one refusal, another after this many refusals without a frame of it in between, if the first and the last are `refused_for` apart.
    static constexpr std::uint32_t enough_refusals = 3;
    static constexpr Duration refused_for = std::chrono::seconds{5};

    /// How long the last host to come that commands keeps its place at least: a flood of them must cost little.
    static constexpr Duration turn = std::chrono::microseconds{500};
    /// Frames within this time belong to one exchange.
    static constexpr Duration exchange = std::chrono::seconds{1};

    explicit PeerBook(const Options& options) : options_{options} {}

    struct Place {
        bool free = false;
        std::optional<ChannelId> gives_way;    // the peer that must be closed first
    };
    /// Whether a stranger may become a peer. A stranger that has come once does not take the place of a peer that was heard within
    /// the timeout or came more than once. One that comes again, in a later exchange, takes the place of a silent peer, or of one
    /// that came once from an address that keeps at least as many places as the stranger's address would have. If its address has
    /// max_of_address places, it takes the place of a peer of that address. Programs of this machine take places from each other,
    /// the longest silent first, but one that came once does not take that of one that came again. Peers of a lower rank take none of
    /// the places that are kept for a higher one. Where places are kept, a host that sends a command always gets one: the last to come
    /// of those that command gives way, so that a crowd of them takes turns, and whoever was there before stays.
    Place place_for(const Endpoint& stranger, TimePoint now, Rank rank = Rank::ordinary);

    /// `near`: it is in a network of our interfaces. It counts as heard at `now`, since its first frame may be reported a little later.
    void add(ChannelId id, const Endpoint& endpoint, bool near, TimePoint now, Rank rank = Rank::ordinary);
    /// Another datagram of the peer came.
    void came(ChannelId id) noexcept { peer(id).once = false; }
    /// A host that sent a command.
    void commanded(ChannelId id) noexcept { peer(id).rank = std::max(peer(id).rank, Rank::commands); }
    Rank rank(ChannelId id) const noexcept { return peer(id).rank; }
    void remove(ChannelId id) { used_.erase(id); }
    void clear() { used_.clear(); }

    void heard(ChannelId id, std::uint8_t source, TimePoint now) noexcept;
    /// What is known of a peer in addition to its endpoint, for the next run of the program, which continues with its socket.
    struct Memory {
        TimePoint heard_at{};
        bool is_host = false;
        bool came_again = false;
        bool once = false;
        bool commands = false;
    };
    Memory memory(ChannelId id) const noexcept;
    /// Restores the memory of a peer that was just added.
    void remember(ChannelId id, const Memory& memory) noexcept;

    /// ICMP reported that nothing listens at the port. Returns whether the peer is overdue now.
    bool refused(ChannelId id, TimePoint now) noexcept;

    /// The peers that are to be forgotten now.
    ChannelSet overdue(TimePoint now) const noexcept;
    /// When a peer may be overdue next, if none is heard until then; TimePoint::max(): never.
    TimePoint next_look(TimePoint now) const noexcept;

    ChannelSet peers() const noexcept { return used_; }
    /// Since when a host of our networks that sent a single datagram listens; std::nullopt: it is none.
    std::optional<TimePoint> listening_since(ChannelId id) const noexcept;

private:
    struct Peer {
        Endpoint endpoint;
        bool near = false;
        bool is_host = false;    // it sent a frame of a host
        bool once = true;        // it sent a single datagram
        Rank rank = Rank::ordinary;
        TimePoint heard_at{};
        TimePoint exchange_began{};    // when it came
        bool came_again = false;       // more than one exchange
        std::uint32_t refusals = 0;    // since it was last heard
        TimePoint first_refused_at{};
        bool is_gone = false;    // concluded from refusals
    };

    // A stranger for which there was no place.
    struct Knock {
        Endpoint endpoint;
        TimePoint first{};
        TimePoint last{};
    };
    static constexpr std::size_t max_knocks = 64;
    static constexpr std::size_t max_knocks_of_address = 2;

    std::size_t places_of(const IpAddress& address) const noexcept;
    bool knocks_again(const Endpoint& stranger, TimePoint now);
    const Peer& peer(ChannelId id) const noexcept { return peers_[index(id)]; }
    Peer& peer(ChannelId id) noexcept { return peers_[index(id)]; }
    bool has_free_place(Rank rank) const noexcept;
    bool may_give_way(const Peer& p, Rank to) const noexcept;
    std::optional<ChannelId> last_that_commands(TimePoint now) const noexcept;
    std::size_t count(Rank at_least) const noexcept;
    bool may_listen(const Peer& p) const noexcept { return p.near && p.is_host; }
    bool is_silent(const Peer& p, TimePoint now) const noexcept { return now - p.heard_at >= options_.timeout; }
    // How long it may be silent until it is forgotten, or counts among those that listen.
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
    std::array<Knock, max_knocks> knocks_;
};

/// Whether a source address can be a peer's: not broadcast, multicast or 0.0.0.0, and not port 0. `own`: our networks.
bool can_be_peer(const Endpoint& sender, const std::vector<Network>& own) noexcept;

}    // namespace anogate
