// The tunnel port: tunnel frames of devices leave by it as datagrams, and what comes in is unwrapped, wrapped or routed.
#pragma once
#include <gateway/tunnel.hpp>
#include <link/udp_listen_link.hpp>

#include <vector>

namespace anogate {

/// The gateway as the tunnel sees it.
class TunnelHost {
public:
    /// The first step of LinkHost::receive(), which every frame takes: the receive filter, limits and switches of the link of
    /// `from`. A frame that came inside a tunnel frame passes here as if it had come by that channel itself. Counts if not.
    virtual bool admit(Channel& from, ano::FrameView frame) = 0;
    /// The same for a tunnel frame that goes on unopened, after admit(): a switch is not to be passed inside one.
    virtual bool admit_unopened(Channel& from, ano::FrameView frame) = 0;
    /// What leaves by `to` without Router::route() is kept from going round all the same: false, and counted, when it came back by
    /// another way than it came by first.
    virtual bool passes_loop_guard(Channel& from, ano::FrameView frame, LinkId to) = 0;
    /// The send filter and limits of `to`, for a frame that leaves inside a tunnel frame. Counts if not.
    virtual bool may_leave(LinkId to, ano::FrameView frame) = 0;
    /// Its source is behind `from`: answers go there.
    virtual void learn(Channel& from, ano::FrameView frame) = 0;
    /// To every channel of `to`.
    virtual void send(LinkId to, ano::FrameView frame) = 0;

protected:
    ~TunnelHost() = default;
};

/// A UDP port like any other, whose peers' tunnel frames are opened, and by which those of our devices leave.
class TunnelLink final : public UdpListenLink {
public:
    /// Where the frames of a wrap rule go.
    struct Target {
        LinkId link;
        std::size_t max_data;
    };
    /// `settings` has a tunnel; `wrap_to`: one for each of its rules.
    TunnelLink(LinkId id, const Settings& settings, std::vector<Target> wrap_to, const LinkContext& context, TunnelHost& host);

    bool takes(ano::FrameView frame) const noexcept { return tunnel_.takes(frame); }
    /// A tunnel frame of a device, of those that it takes: what is inside leaves as one datagram.
    void carry(Channel& from, ano::FrameView frame);
    /// A tunnel frame out of a tunnel frame was to leave by us again.
    void refuse_nested() noexcept { tunnel_.refuse(&TunnelCounters::tunnel_nested); }

    const TunnelCounters& counters() const noexcept { return tunnel_.counters(); }
    LinkFacts facts() const override;

private:
    void opened(const Endpoint& local) override;
    bool allowed(const Endpoint& sender, TimePoint now) override;
    bool joins_gateways() const override { return true; }
    bool welcomes(const Endpoint& sender, ano::FrameView frame) override;
    void deliver(Channel& channel, const Endpoint& sender, ano::FrameView frame) override;
    void delivered() override;

    void pass_on(Channel& channel, const Endpoint& sender, ano::FrameView frame);
    void wrap(std::size_t rule, Channel& channel, const Endpoint& sender, ano::FrameView frame);
    void refresh_networks(TimePoint now);
    std::optional<IpAddress> our_address(const IpAddress& there);

    struct Way {
        IpAddress there;
        std::optional<IpAddress> source;
    };

    TunnelHost& host_;
    Tunnel tunnel_;
    std::vector<Target> wrap_to_;
    TunnelCounters before_stranger_;
    std::optional<std::size_t> wrapping_;    // the rule, while a datagram's frames are collected
    bool took_ = false;                      // something of the datagram
    bool cannot_wrap_ = false;
    TimePoint looked_at_{};
    std::optional<Way> last_way_;    // valid as long as what was seen then
};

}    // namespace anogate
