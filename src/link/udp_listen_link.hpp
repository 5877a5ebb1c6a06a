// A UDP port. Whoever sends it a whole good frame becomes a peer with a channel of its own.
#pragma once
#include <gateway/backoff.hpp>
#include <link/ip_socket.hpp>
#include <link/link_context.hpp>

namespace anogate {

class UdpListenLink final : public Link {
public:
    UdpListenLink(LinkId id, LinkSettings settings, const LinkContext& context);
    ~UdpListenLink() override;

    void start() override { try_open(); }
    void stop_reading() override;
    void stop() override;
    void flush(Channel& channel) override;
    LinkFacts facts() const override;
    std::string trouble() const override;
    Stray stray() const override { return {stray_, probe_.counters().v7_frames}; }

private:
    struct Peer;

    void try_open();
    void fail(std::string why);
    void read();
    void take(const sockaddr_storage& sender, std::span<const std::uint8_t> datagram, TimePoint now);
    Peer* find(const Endpoint& endpoint) noexcept;
    Peer* admit(const Endpoint& endpoint, std::span<const std::uint8_t> datagram, TimePoint now);
    bool allowed(const IpAddress& address, TimePoint now);
    bool holds_a_frame(std::span<const std::uint8_t> datagram, TimePoint now);
    void forget(Peer& peer);
    void forget_silent_peers();
    void expire(Peer& peer);

    LinkContext context_;
    Descriptor descriptor_;
    Backoff backoff_;
    Alarm retry_;
    Alarm silence_;
    std::vector<std::unique_ptr<Peer>> peers_;
    Peer* latest_ = nullptr;    // the one heard last: most datagrams are its
    ano::FrameParser probe_;    // for senders that are no peers yet
    ReceiveCounters stray_;
    std::vector<Network> allow_;
    TimePoint networks_read_at_{};
    Endpoint local_;
};

}  // namespace anogate
