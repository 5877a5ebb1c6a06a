// A listening UDP port. The sender of a complete valid frame becomes a peer with its own channel.
#pragma once
#include <gateway/arrival.hpp>
#include <gateway/peers/listener_check.hpp>
#include <gateway/peers/peer_book.hpp>
#include <gateway/turn_shares.hpp>
#include <gateway/v7_translation.hpp>
#include <link/interface_watch.hpp>
#include <link/link_context.hpp>
#include <link/own_networks.hpp>
#include <link/pacing.hpp>
#include <link/reconnect.hpp>
#include <link/refusals.hpp>
#include <link/udp/error_queue.hpp>
#include <link/udp/ip_socket.hpp>
#include <link/udp/udp_settings.hpp>
#include <sys/descriptor.hpp>

namespace anogate {

class UdpListenLink : public Link, public PeerPlaces, public UnassignedReceiver, public StorableLink, public LocalPort {
public:
    UdpListenLink(LinkId id, LinkSettings settings, const LinkContext& context);
    ~UdpListenLink() override;

    void start() override { reconnect_.start(); }
    void stop_reading() override;
    void stop() override;
    void flush(Channel& channel) override;
    void forget_peer(ChannelId channel) override;
    std::optional<ChannelId> peer_to_replace(PeerBook::Rank to, TimePoint now) const override {
        return book_.longest_silent(to, now);
    }
    LinkFacts facts() const override;
    LinkError trouble() const override;
    int storable_wire() const override { return descriptor_.fd(); }
    std::vector<StoredPeer> peers() const override;
    std::optional<TimePoint> listening_since(ChannelId channel) const override { return book_.listening_since(channel); }
    UnassignedTraffic unassigned_traffic() const override {
        return {unassigned_, probe_.counters().v7_frames, gateways_, no_place_, no_memory_, outsiders_, &probe_};
    }
    std::uint16_t local_port() const override {
        return descriptor_.is_open() ? local_.port : settings().as<UdpListenSettings>().local.port;
    }

protected:
    /// Called when the socket is bound.
    virtual void opened(const Endpoint&) {}
    /// Whether datagrams of an unknown sender are parsed.
    virtual bool allowed(const Endpoint& sender, TimePoint now);
    /// Whether this valid frame of an unknown sender makes it a peer. Called for each frame of a datagram until the result is
    /// true; then deliver() gets all of them.
    virtual bool welcomes(const Endpoint&, ano::FrameView) { return true; }
    /// Whether peers may be listening sockets of other gateways. If so, sending to peers outside our networks is not limited.
    virtual bool joins_gateways() const { return false; }
    /// Called for each valid frame of a peer.
    virtual void deliver(Channel& channel, const Endpoint&, ano::FrameView frame) { context_.host.receive(channel, frame); }
    /// Called when all frames of a datagram have been delivered.
    virtual void delivered() {}

    const LinkContext& context() const noexcept { return context_; }
    /// Sends one datagram. Returns 0 or errno; EBADF while the socket is not open.
    int send(const Endpoint& to, std::span<const std::uint8_t> bytes);
    bool is_open() const noexcept { return descriptor_.is_open(); }

private:
    struct Peer;

    Opened<void> open();
    void restore_peers(std::vector<StoredPeer> peers, TimePoint now);
    void fail(LinkError why);
    void read();
    bool read_batch();
    void receive(const sockaddr_storage& sender, std::span<const std::uint8_t> datagram, TimePoint arrived_at, TimePoint now);
    void receive(Peer& peer, std::span<const std::uint8_t> datagram, TimePoint arrived_at, TimePoint now);
    bool is_crowded() const;
    void store(Peer& peer, std::span<const std::uint8_t> datagram, TimePoint arrived_at);
    void process_waiting(Duration time);
    std::size_t process_next(Peer& peer, TimePoint now);
    Peer& peer_of(ChannelId channel) noexcept;
    void receive(Peer& peer, ano::FrameView frame, TimePoint now);
    void receive_v7(Peer& peer, ano::FrameView frame);
    void flush_v7(Peer& peer);
    bool write_v7(Peer& peer);
    bool has_v7_frame(std::span<const std::uint8_t> datagram, bool& commands);
    Peer* find(const Endpoint& endpoint) noexcept;
    Peer* admit(const Endpoint& endpoint, std::span<const std::uint8_t> datagram, TimePoint now);
    bool can_be_peer(const Endpoint& sender, TimePoint now);
    bool is_admitted(const Endpoint& sender, std::span<const std::uint8_t> datagram, TimePoint now, bool& commands);
    bool is_trusted(const IpAddress& address) const;
    PeerBook::Rank rank_of(const Endpoint& endpoint, bool commands) const;
    Peer* make_peer(const Endpoint& endpoint, TimePoint now, PeerBook::Rank rank);
    void refuse(std::span<const std::uint8_t> datagram);
    bool is_far(const IpAddress& address, TimePoint now);
    void end_of_datagram(Peer& peer, TimePoint now);
    void ask_suspect(Peer& peer, TimePoint now);
    void heard_notice(const Endpoint& from, const ListeningNotice& notice, TimePoint now);
    void send_notice(const Endpoint& to, const std::optional<ListeningNotice>& notice);
    void forget(Peer& peer);
    void evict(ChannelId channel, TimePoint now);
    void forget_overdue_peers();
    bool read_reports();
    void limit_reports(std::size_t count, TimePoint now);
    bool has_returned(const Peer& peer, TimePoint now) const;
    void expire(Peer& peer);
    void await_rest(Peer& peer);
    void flush_all();

    LinkContext context_;
    Descriptor descriptor_;
    Arrival arrival_;
    Reconnect reconnect_;
    Alarm look_;    // to remove expired peers
    InterfaceWatch interface_watch_;
    Pacing pacing_;                   // for all peers together
    std::size_t first_served_ = 0;    // index of the peer to send to first; rotates
    std::vector<std::unique_ptr<Peer>> peers_;
    Peer* latest_ = nullptr;    // the last sender, found without a search
    ChannelSet waiting_;        // the peers with datagrams that wait for their turn
    TurnShares shares_;
    TimePoint turn_ends_{};    // datagrams read later wait
    Alarm next_turn_;
    ano::FrameParser probe_;                          // parses datagrams of unknown senders
    std::optional<ano::v7::FrameParser> v7_probe_;    // the same with `protocol` v7
    V7Counters v7_of_gone_{};                         // of the peers that were removed
    ReceiveCounters unassigned_;
    PeerBook book_;
    std::function<std::uint64_t()> random_;
    ListenerCheck check_;
    std::uint64_t gateways_ = 0;     // other gateways that sent here
    std::uint64_t no_place_ = 0;     // refused datagrams of unknown senders: max_peers is reached
    Refusals no_channel_;            // the same: all channels of the gateway are in use
    std::uint64_t no_memory_ = 0;    // the same: too little memory for a peer
    std::uint64_t outsiders_ = 0;    // the same: outside `allow`
    std::string last_gateway_;       // the last of these gateways
    OwnNetworks networks_;
    ReportLimit report_limit_;
    Alarm reports_again_;    // while none are kept
    std::function<bool()> read_reports_;
    Endpoint local_;
};

}    // namespace anogate
