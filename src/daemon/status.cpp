#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <config/link_kind.hpp>
#include <daemon/answer_json.hpp>
#include <daemon/gateway.hpp>
#include <daemon/gpio_control.hpp>
#include <daemon/status.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

void put(Json& json, const ReceiveCounters& received, const SendCounters& sent, std::size_t waiting) {
    for (const auto& row : receive_counters) json[std::string{row.name}] = received.*row.value;
    for (const auto& row : send_counters) json[std::string{row.name}] = sent.*row.value;
    json["waiting"] = waiting;
}

// A link's own counters: of its channels, of those that are gone, and of what never belonged to one.
struct Totals {
    LinkFigures figures;
    std::size_t waiting = 0;
};

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

// A device on this link whose frames go to another, for it has the port id of that.
std::uint8_t hidden_device(const Gateway& gateway, LinkId link, TimePoint now) {
    const Router& router = gateway.forwarder().router();
    for (std::uint8_t a = 1; a <= ano::address::last_port_id; ++a) {
        const LinkSet port = router.port(a);
        if (!port.empty() && !port.contains(link) && router.learned(a, now).links.contains(link)) return a;
    }
    return 0;
}

bool leads_hosts_to(const Settings& settings, const std::string& link) {
    return std::ranges::any_of(settings.routes, [&](const RouteSettings& route) {
        return route.link == link && route.first <= ano::address::host && ano::address::host <= route.last;
    });
}

Totals totals(const Gateway& gateway, const LinkState& state, TimePoint now) {
    Totals t;
    const LinkTraffic& traffic = gateway.forwarder().traffic(state.link->id());
    LinkFigures& f = t.figures;
    f.words = state.link->settings().kind->hints;
    f.up = state.up;
    f.listens = state.link->settings().kind->listens;
    f.channels = traffic.channels.size();
    f.waits_to_hear = !f.listens && hello_interval(state.link->settings()) == Duration{};
    f.for_hosts = leads_hosts_to(gateway.settings(), state.link->name());
    f.up_for = now - state.since;
    f.untaken_for = traffic.untaken.duration(now);
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
        t.waiting += channel.waiting();
        if (channel.arrived_at != TimePoint{})
            f.bytes_ago = std::min(f.bytes_ago.value_or(Duration::max()), now - channel.arrived_at);
        if (channel.heard_at == TimePoint{}) continue;
        f.silent_for = std::min(f.silent_for.value_or(Duration::max()), now - channel.heard_at);
    }
    return t;
}

Json channel_json(const Channel& channel, TimePoint now) {
    Json json;
    json["peer"] = channel.peer;
    json["since_s"] = in_seconds(now - channel.opened_at);
    if (channel.heard_at != TimePoint{}) json["heard_s"] = in_seconds(now - channel.heard_at);
    put(json, channel.received(), channel.sent(), channel.waiting());
    return json;
}

Json link_json(const Gateway& gateway, const LinkState& state, TimePoint now) {
    const Totals total = totals(gateway, state, now);
    Json json;
    json["name"] = state.link->name();
    json["kind"] = state.link->settings().kind->name;
    if (state.link->settings().id != 0) json["id"] = state.link->settings().id;
    else json["id"] = nullptr;
    json["state"] = state.up ? "up" : "waiting";
    json["since_s"] = in_seconds(now - state.since);
    json["error"] = state.up ? state.link->trouble() : state.error;
    json["hint"] = hint(total.figures);
    for (const auto& fact : state.link->facts())
        std::visit([&](const auto& v) { json[std::string{fact.first}] = v; }, fact.second);
    if (state.link->settings().required) json["required"] = true;
    if (!state.link->settings().group.empty()) json["group"] = state.link->settings().group;
    json["channels"] = Json::array();
    const ChannelSet channels = gateway.forwarder().traffic(state.link->id()).channels;
    for (const ChannelId id : channels) json["channels"].push_back(channel_json(gateway.channel(id), now));
    put(json, total.figures.received, total.figures.sent, total.waiting);
    return json;
}

Json names(const Gateway& gateway, LinkSet links) {
    Json json = Json::array();
    for (const LinkId id : links) json.push_back(gateway.name(id));
    return json;
}

Json route_json(const Gateway& gateway, std::uint8_t address, LinkSet links, Via via) {
    Json json{{"address", ano::hex_byte(address)}, {"who", ano::address::who(address)}, {"links", names(gateway, links)}};
    json["via"] = text(via);
    return json;
}

// One row an address, by the rule that decides for it.
Json routes_json(const Gateway& gateway, TimePoint now) {
    const Router& router = gateway.forwarder().router();
    Json json = Json::array();
    for (unsigned a = 1; a < ano::address::broadcast; ++a) {
        const auto address = static_cast<std::uint8_t>(a);
        if (address == gateway.settings().gateway.id) {
            json.push_back(route_json(gateway, address, {}, Via::own));
        } else if (const LinkSet links = router.port(address); !links.empty()) {
            json.push_back(route_json(gateway, address, links, Via::port));
        } else if (const LinkSet pinned = router.pinned(address); !pinned.empty()) {
            json.push_back(route_json(gateway, address, pinned, Via::pinned));
        } else if (const Router::Learned learned = router.learned(address, now); !learned.links.empty()) {
            json.push_back(route_json(gateway, address, learned.links, Via::learned));
            json.back()["age_s"] = in_seconds(now - learned.last);
        }
    }
    return json;
}

Json conflicts_json(const Gateway& gateway, TimePoint now) {
    Json json = Json::array();
    for (const Conflict& c : gateway.forwarder().router().conflicts(now)) {
        json.push_back({{"address", ano::hex_byte(c.address)}, {"links", names(gateway, c.links)}, {"count", c.count}});
        Json& by = json.back()["claimed_by"] = nullptr;
        if (const Forwarder::Claimant* claimant = gateway.forwarder().claimant(c))
            by = {{"link", gateway.name(claimant->link)}, {"peer", claimant->peer}};
    }
    return json;
}

Json gateway_json(const Gateway& gateway, TimePoint now) {
    const GatewaySettings& settings = gateway.settings().gateway;
    Json json;
    if (settings.id != 0) json["id"] = settings.id;
    else json["id"] = nullptr;
    json["name"] = settings.name;
    json["version"] = ANOGATE_VERSION;
    json["uptime_s"] = in_seconds(now - gateway.started_at());
    json["standstills"] = gateway.loop().standstills();
    json["longest_standstill_s"] = in_seconds(gateway.loop().longest());
    json["own_frames"] = gateway.forwarder().router().own_frames();
    json["config"] = config_json(gateway.config_state(), now);
    return json;
}

Json tunnel_json(const Gateway& gateway) {
    Json json = Json::object();
    if (const TunnelLink* tunnel = gateway.tunnel())
        for (const auto& row : tunnel_counters) json[std::string{row.name}] = tunnel->counters().*row.value;
    return json;
}

Json links_json(const Gateway& gateway, TimePoint now) {
    Json json = Json::array();
    for (const LinkState& state : gateway.links()) json.push_back(link_json(gateway, state, now));
    return json;
}

}    // namespace

std::string status_json(Gateway& gateway) {
    const TimePoint now = gateway.now();
    Json json;
    json["gateway"] = gateway_json(gateway, now);
    json["links"] = links_json(gateway, now);
    json["routes"] = routes_json(gateway, now);
    json["conflicts"] = conflicts_json(gateway, now);
    json["tunnel"] = tunnel_json(gateway);
    json["gpio"] = gpio_json(gateway.gpio(), now);
    return line_of(json);
}

std::string status_text(Gateway& gateway) {
    const TimePoint now = gateway.now();
    std::string text;
    for (const LinkState& state : gateway.links()) {
        const Totals t = totals(gateway, state, now);
        text += state.link->name() + (state.up ? ": up" : ": waiting: " + state.error);
        text += ", in " + std::to_string(t.figures.received.frames_in) + ", out " + std::to_string(t.figures.sent.frames_out);
        if (const std::string h = hint(t.figures); !h.empty()) text += " (" + h + ")";
        text += "\n";
    }
    return text;
}

FrameCount frame_count(const Gateway& gateway) {
    FrameCount count;
    for (const LinkState& state : gateway.links()) {
        const LinkFigures figures = totals(gateway, state, {}).figures;
        count.in += figures.received.frames_in;
        count.out += figures.sent.frames_out;
    }
    return count;
}

std::vector<std::string> HintLog::news(Gateway& gateway) {
    const TimePoint now = gateway.now();
    std::vector<std::string> lines;
    for (const LinkState& state : gateway.links()) {
        std::set<std::string>& told = told_[state.link->name()];
        if (!state.up) told.clear();
        std::string hint = hint_of_trouble(totals(gateway, state, now).figures);
        if (hint.empty() || !told.insert(hint).second) continue;
        lines.push_back(state.link->name() + ": " + std::move(hint));
    }
    return lines;
}

}    // namespace anogate
