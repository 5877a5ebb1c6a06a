// One fixed UDP peer, which may be a broadcast address or a multicast group.
#pragma once
#include <gateway/arrival.hpp>
#include <link/interface_watch.hpp>
#include <link/link_context.hpp>
#include <link/own_networks.hpp>
#include <link/pacing.hpp>
#include <link/raw_port.hpp>
#include <link/reconnect.hpp>
#include <link/stored_link.hpp>
#include <link/udp/ip_socket.hpp>
#include <link/udp/udp_settings.hpp>
#include <link/v7_edge.hpp>
#include <sys/descriptor.hpp>

#include <memory>
#include <optional>

namespace anogate {

struct SendReport;

/// An absent peer is no error: its ICMP refusals are counted and shown.
class UdpLink final : public Link, public RawPort, public StorableLink, public LocalPort {
public:
    UdpLink(LinkId id, LinkSettings settings, const LinkContext& context);
    ~UdpLink() override;

    void start() override;
    void stop_reading() override;
    void stop() override;
    void flush(Channel& channel) override;
    std::uint16_t local_port() const override { return descriptor_.is_open() ? local_.port : 0; }
    /// -1 for a multicast group: the groups and the sending interface of a stored socket can't be read, so the next run would
    /// keep them.
    int storable_wire() const override { return is_multicast_ ? -1 : descriptor_.fd(); }
    LinkFacts facts() const override;
    LinkError trouble() const override;
    void set_tap(RawTap* tap) override { tap_ = tap; }
    /// Sends the bytes as one datagram.
    bool write_raw(std::span<const std::uint8_t> bytes) override;

private:
    Opened<void> find_and_open();
    Opened<void> open(const Endpoint& peer);
    void look_up_again();
    void stop_looking_up();
    EndpointSpec watched() const;
    Opened<UniqueFd> open_to(const Endpoint& peer);
    Opened<void> join_group(int fd) const;
    void keep_joined();
    void fail(LinkError why);
    void read();
    bool own(const sockaddr_storage& sender, TimePoint now);
    void receive(ano::FrameView frame);
    void deliver();
    void flush_v7();
    bool write_v7();
    void note(const SendReport& report);

    LinkContext context_;
    Descriptor descriptor_;
    Arrival arrival_;
    Channel* channel_ = nullptr;
    Reconnect reconnect_;
    Alarm expiry_;
    Alarm again_;    // after SendResult::no_memory
    Alarm rejoin_;
    Alarm look_up_;    // for a peer given by name
    InterfaceWatch interface_watch_;
    Pacing pacing_;
    RawTap* tap_ = nullptr;
    std::optional<StoredLink> stored_;    // of the previous run, until the socket is open
    bool connected_ = false;              // false for broadcast and multicast
    bool is_multicast_ = false;
    SocketAddress to_;
    unsigned to_interface_ = 0;    // of the peer's address; 0: none
    Endpoint local_;
    OwnNetworks networks_;    // to recognise our own datagrams
    std::uint64_t refused_ = 0;
    LinkError trouble_;
    TimePoint trouble_at_{};
    std::unique_ptr<V7Edge> v7_;    // nullptr: the devices use V8
};

}    // namespace anogate
