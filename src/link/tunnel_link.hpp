// The tunnel port: sends tunnel frames of devices as datagrams. Received frames are unwrapped, wrapped or routed.
#pragma once
#include <gateway/forwarder.hpp>
#include <gateway/tunnel/tunnel.hpp>
#include <gateway/tunnel/tunnel_port.hpp>
#include <link/udp/udp_listen_link.hpp>
#include <sys/alarm.hpp>

#include <vector>

namespace anogate {

/// A listening UDP port that unwraps the tunnel frames of its peers and sends those of our devices.
class TunnelLink final : public UdpListenLink, public TunnelPort {
public:
    /// The destination of a wrap rule.
    struct Target {
        LinkId link;
        std::size_t max_data;
    };
    /// `settings` must have a tunnel; `wrap_to` has one entry for each of its rules.
    TunnelLink(LinkId id, const Settings& settings, std::vector<Target> wrap_to, const LinkContext& context,
               Forwarder& forwarder);
    /// To be called when the links of the wrap rules, or their ids, have changed.
    void set_targets(std::vector<Target> wrap_to) { wrap_to_ = std::move(wrap_to); }
    /// The settings of the tunnel port as a link.
    static LinkSettings link_settings(const Settings& settings);

    bool takes(ano::FrameView frame) const noexcept override { return tunnel_.takes(frame); }
    void carry(Channel& from, ano::FrameView frame) override;
    void refuse_nested() noexcept override { tunnel_.refuse(&TunnelCounters::tunnel_nested); }

    const TunnelCounters& counters() const noexcept { return tunnel_.counters(); }
    LinkFacts facts() const override;
    /// Also reports a configured host that has no address.
    LinkError trouble() const override { return no_such_host_.text.empty() ? UdpListenLink::trouble() : no_such_host_; }
    void stop_reading() override;
    void stop() override;

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
    void look_up_hosts();
    void stop_looking_up();
    std::optional<IpAddress> our_address(const IpAddress& there);

    struct Path {
        IpAddress there;
        std::optional<IpAddress> source;
    };

    Forwarder& forwarder_;
    Tunnel tunnel_;
    std::vector<Target> wrap_to_;
    TunnelCounters before_stranger_;
    bool has_accepted_ = false;        // a frame of this datagram was accepted
    OwnNetworks seen_networks_;        // a separate cache, so that refresh_networks() detects every new read
    std::optional<Path> last_path_;    // cleared by refresh_networks()
    HostAddresses hosts_;              // of each configured host; empty until known
    Alarm look_up_;
    LinkError no_such_host_;
};

}    // namespace anogate
