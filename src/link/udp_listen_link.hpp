// A UDP port. Whoever sends it a whole good frame becomes a peer with a channel of its own.
#pragma once
#include <gateway/arrival.hpp>
#include <gateway/listener_check.hpp>
#include <gateway/peer_book.hpp>
#include <link/descriptor.hpp>
#include <link/interface_watch.hpp>
#include <link/ip_socket.hpp>
#include <link/link_context.hpp>
#include <link/pacing.hpp>
#include <link/reconnect.hpp>
#include <link/udp_settings.hpp>

namespace anogate {

class UdpListenLink : public Link {
public:
    UdpListenLink(LinkId id, LinkSettings settings, const LinkContext& context);
    ~UdpListenLink() override;

    void start() override { reconnect_.start(); }
    void stop_reading() override;
    void stop() override;
    void flush(Channel& channel) override;
    void forget_peer(ChannelId channel) override;
    LinkFacts facts() const override;
    LinkError trouble() const override;
    int storable_wire() const override { return descriptor_.fd(); }
    std::vector<StoredPeer> peers() const override;
    UnassignedTraffic unassigned_traffic() const override {
        return {unassigned_, probe_.counters().v7_frames, gateways_, no_place_};
    }
    std::uint16_t local_port() const override {
        return descriptor_.is_open() ? local_.port : settings().as<UdpListenSettings>().local.port;
    }

protected:
    /// The socket is bound.
    virtual void opened(const Endpoint&) {}
    /// Whether a stranger's datagrams are looked at.
    virtual bool allowed(const Endpoint& sender, TimePoint now);
    /// Whether a good frame in a stranger's datagram makes it a peer. Asked until one does; deliver() then gets them all.
    virtual bool welcomes(const Endpoint&, ano::FrameView) { return true; }
    /// Peers may be listening sockets of other gateways, and what they are sent is nobody's concern here.
    virtual bool joins_gateways() const { return false; }
    /// A good frame of a peer.
    virtual void deliver(Channel& channel, const Endpoint&, ano::FrameView frame) { context_.host.receive(channel, frame); }
    /// All that a datagram brought has been delivered.
    virtual void delivered() {}

    const LinkContext& context() const noexcept { return context_; }
    /// Sends one datagram; 0, or what errno says: EBADF while the socket is not open.
    int send(const Endpoint& to, std::span<const std::uint8_t> bytes);
    bool is_open() const noexcept { return descriptor_.is_open(); }

private:
    struct Peer;

    Opened<void> open();
    void restore_peers(std::vector<StoredPeer> peers, TimePoint now);
    void fail(LinkError why);
    void read();
    void take(const sockaddr_storage& sender, std::span<const std::uint8_t> datagram, TimePoint arrived_at, TimePoint now);
    void take(Peer& peer, ano::FrameView frame, TimePoint now);
    Peer* find(const Endpoint& endpoint) noexcept;
    Peer* admit(const Endpoint& endpoint, std::span<const std::uint8_t> datagram, TimePoint now);
    bool can_be_peer(const Endpoint& sender, TimePoint now);
    bool is_welcome(const Endpoint& sender, std::span<const std::uint8_t> datagram, TimePoint now);
    Peer* make_peer(const Endpoint& endpoint, TimePoint now);
    void refuse(std::span<const std::uint8_t> datagram);
    bool is_far(const IpAddress& address, TimePoint now);
    void end_of_datagram(Peer& peer, TimePoint now);
    void ask_suspect(Peer& peer, TimePoint now);
    void heard_notice(const Endpoint& from, const ListeningNotice& notice, TimePoint now);
    void say(const Endpoint& to, const std::optional<ListeningNotice>& notice);
    void forget(Peer& peer);
    void forget_overdue_peers();
    bool is_near(const IpAddress& address, TimePoint now);
    bool take_reports();
    void expire(Peer& peer);
    void flush_all();

    LinkContext context_;
    Descriptor descriptor_;
    Arrival arrival_;
    Reconnect reconnect_;
    Alarm look_;    // at who is overdue
    InterfaceWatch interface_watch_;
    Pacing pacing_;                   // of all peers together
    std::size_t first_served_ = 0;    // of the peers, when more may go: each has its turn
    std::vector<std::unique_ptr<Peer>> peers_;
    Peer* latest_ = nullptr;    // the one heard last: most datagrams are its
    ano::FrameParser probe_;    // for senders that are no peers yet
    ReceiveCounters unassigned_;
    PeerBook book_;
    std::function<std::uint64_t()> random_;
    ListenerCheck check_;
    std::uint64_t gateways_ = 0;       // that turned up as peers
    std::uint64_t no_place_ = 0;       // datagrams of strangers for whom nobody gave way
    std::string last_gateway_;         // of those that turned up
    std::vector<Network> networks_;    // of our interfaces
    TimePoint networks_read_at_{};
    std::function<bool()> take_reports_;
    Endpoint local_;
};

}    // namespace anogate
