// The tunnel port: tunnel frames of devices leave by it as datagrams, and what comes in is unwrapped, wrapped or routed.
#pragma once
#include <gateway/forwarder.hpp>
#include <gateway/tunnel.hpp>
#include <gateway/tunnel_port.hpp>
#include <link/udp_listen_link.hpp>

#include <vector>

namespace anogate {

/// A UDP port like any other, whose peers' tunnel frames are opened, and by which those of our devices leave.
class TunnelLink final : public UdpListenLink, public TunnelPort {
public:
    /// Where the frames of a wrap rule go.
    struct Target {
        LinkId link;
        std::size_t max_data;
    };
    /// `settings` has a tunnel; `wrap_to`: one for each of its rules.
    TunnelLink(LinkId id, const Settings& settings, std::vector<Target> wrap_to, const LinkContext& context,
               Forwarder& forwarder);
    /// The links of the wrap rules are others now, or have other numbers.
    void set_targets(std::vector<Target> wrap_to) { wrap_to_ = std::move(wrap_to); }
    /// Its own settings, as if it stood among the links.
    static LinkSettings link_settings(const Settings& settings);

    bool takes(ano::FrameView frame) const noexcept override { return tunnel_.takes(frame); }
    void carry(Channel& from, ano::FrameView frame) override;
    void refuse_nested() noexcept override { tunnel_.refuse(&TunnelCounters::tunnel_nested); }

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

    Forwarder& forwarder_;
    Tunnel tunnel_;
    std::vector<Target> wrap_to_;
    TunnelCounters before_stranger_;
    bool took_ = false;    // something of the datagram
    TimePoint looked_at_{};
    std::optional<Way> last_way_;    // valid as long as what was seen then
};

}    // namespace anogate
