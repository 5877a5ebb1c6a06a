#include <ano/address.hpp>
#include <config/link_kind.hpp>
#include <daemon/gateway.hpp>
#include <daemon/link_report.hpp>

#include <algorithm>
#include <string_view>

namespace anogate {
namespace {

SharedSource shared_source(const Gateway& gateway, LinkId link, TimePoint now) {
    SharedSource shared = SharedSource::none;
    for (const Conflict& c : gateway.forwarder().router().conflicts(now)) {
        if (!c.links.contains(link)) continue;
        if (!c.links.has_several()) return SharedSource::two_peers;
        if (!gateway.forwarder().same_device().differ(c.address)) return SharedSource::one_device;
        shared = SharedSource::two_devices;
    }
    return shared;
}

// A device on this link whose frames go to another link, since that link has the id of the device as its port id.
std::uint8_t hidden_device(const Gateway& gateway, LinkId link, TimePoint now) {
    const Router& router = gateway.forwarder().router();
    for (std::uint8_t a = 1; a <= ano::address::last_port_id; ++a) {
        const LinkSet port = router.port(a);
        if (!port.empty() && !port.contains(link) && router.learned(a, now).links.contains(link)) return a;
    }
    return 0;
}

// The link where `host` was heard last, if all links where it was heard are down; otherwise empty.
std::string_view link_of_lost(const Gateway& gateway, std::uint8_t host) {
    std::string_view link;
    TimePoint last = TimePoint::min();
    for (const LinkState& state : gateway.links())
        for (const ChannelId channel : gateway.forwarder().traffic(state.link->id()).channels) {
            const auto at = gateway.forwarder().router().heard_at(host, channel);
            if (!at) continue;
            if (state.up) return {};
            if (*at >= last) link = state.link->name();
            last = std::max(last, *at);
        }
    return link;
}

std::string_view link_of_lost_hosts(const Gateway& gateway) {
    const std::string_view link = link_of_lost(gateway, ano::address::host);
    return !link.empty() ? link : link_of_lost(gateway, ano::address::ros_bridge);
}

bool leads_hosts_to(const Settings& settings, const std::string& link) {
    return std::ranges::any_of(settings.routes, [&](const RouteSettings& route) {
        return route.link == link && route.first <= ano::address::host && ano::address::host <= route.last;
    });
}

}    // namespace

LinkReport report_of(const Gateway& gateway, const LinkState& state, TimePoint now) {
    LinkReport report;
    const LinkTraffic& traffic = gateway.forwarder().traffic(state.link->id());
    LinkFigures& f = report.figures;
    f.words = state.link->settings().kind->hints;
    f.up = state.up;
    f.is_over = state.link->is_over();
    f.listens = state.link->settings().kind->listens;
    f.channels = traffic.channels.size();
    f.waits_to_hear = !f.listens && hello_interval(state.link->settings()) == Duration{};
    f.for_hosts = leads_hosts_to(gateway.settings(), state.link->name());
    f.up_for = now - state.since;
    f.untaken_for = traffic.untaken.duration(now);
    f.hosts_link = link_of_lost_hosts(gateway);
    f.shared = shared_source(gateway, state.link->id(), now);
    f.hidden = hidden_device(gateway, state.link->id(), now);
    f.received = traffic.gone_received;
    f.sent = traffic.gone_sent;
    f.came_stale = traffic.came_stale;
    const UnassignedTraffic unassigned = state.link->unassigned_traffic();
    add(f.received, unassigned.received);
    f.v7_frames = unassigned.v7_frames;
    f.gateways = unassigned.gateways;
    f.no_place = unassigned.no_place;
    for (const ChannelId id : traffic.channels) {
        const Channel& channel = gateway.channel(id);
        if (const auto ring = gateway.forwarder().rings().ring(id, now)) {
            f.ring_out = gateway.name(ring->out);
            f.ring_back = gateway.name(ring->back);
            f.ring_is_certain = ring->certain;
        }
        add(f.received, channel.received());
        add(f.sent, channel.sent());
        f.v7_frames += channel.parser.counters().v7_frames;
        f.skipped_since += channel.skipped_since_heard();
        report.waiting += channel.waiting();
        if (channel.arrived_at != TimePoint{})
            f.bytes_ago = std::min(f.bytes_ago.value_or(Duration::max()), now - channel.arrived_at);
        if (channel.heard_at == TimePoint{}) continue;
        f.silent_for = std::min(f.silent_for.value_or(Duration::max()), now - channel.heard_at);
    }
    return report;
}

}    // namespace anogate
