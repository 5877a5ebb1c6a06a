#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano_json/answer_json.hpp>
#include <ano_json/describe.hpp>
#include <config/link_kind.hpp>
#include <gpio/gpio_control.hpp>
#include <runtime/gateway.hpp>
#include <runtime/link_report.hpp>
#include <runtime/route_rows.hpp>
#include <status/status.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bitset>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t counters = std::size(receive_counters) + std::size(send_counters) + 1;

// Reserves memory: an ordered object that grows beyond its capacity copies all its members completely.
Json object_with_room(std::size_t members) {
    Json json = Json::object();
    json.get_ref<Json::object_t&>().reserve(members);
    return json;
}

// Appends the counters without a search: operator[] would search for each name among all others. The names must not be in `json`
// yet.
void put(Json& json, const ReceiveCounters& received, const SendCounters& sent, std::size_t waiting) {
    Json::object_t& object = json.get_ref<Json::object_t&>();
    for (const auto& row : receive_counters) object.emplace_back(row.name, received.*row.value);
    for (const auto& row : send_counters) object.emplace_back(row.name, sent.*row.value);
    object.emplace_back("waiting", waiting);
}

Json channel_json(const Channel& channel, const Link& link, TimePoint now) {
    const PeerPlaces* const places = link.as<PeerPlaces>();
    const auto listening_since = places ? places->listening_since(channel.id) : std::nullopt;
    Json json = object_with_room(5 + counters);
    json["peer"] = channel.peer;
    json["since_s"] = in_seconds(now - channel.opened_at);
    if (channel.heard_at != TimePoint{}) json["heard_s"] = in_seconds(now - channel.heard_at);
    if (listening_since) json["listening_since_s"] = in_seconds(now - *listening_since);
    if (const auto age = places ? places->unacknowledged_for(channel.id) : std::nullopt) json["unacknowledged_ms"] = age->count();
    put(json, channel.received(), channel.sent(), channel.waiting());
    return json;
}

Json args_json(const Hint& hint) {
    Json json = Json::object();
    for (const auto& [name, value] : hint.args) std::visit([&, n = std::string{name}](const auto& v) { json[n] = v; }, value);
    return json;
}

void put(Json& json, const LinkError& error) {
    json["error"] = error.text;
    json["error_id"] = error.text.empty() ? "" : error.id;
    Json& arguments = json["error_args"] = Json::object();
    for (const auto& [name, value] : error.arguments) arguments[std::string{name}] = value;
}

Json replayed_json(const std::bitset<256>& addresses) {
    Json json = Json::array();
    for (unsigned a = 1; a < ano::address::broadcast; ++a) {
        const auto address = static_cast<std::uint8_t>(a);
        if (addresses.test(a)) json.push_back({{"address", ano::hex_byte(address)}, {"who", ano::address::who(address)}});
    }
    return json;
}

Json link_json(const Gateway& gateway, const LinkState& state, TimePoint now) {
    const LinkReport report = report_of(gateway, state, now);
    const Hint& hint = report.hint;
    Json json = object_with_room(32 + counters);
    json["name"] = state.link->name();
    json["kind"] = state.link->settings().kind->name;
    if (state.link->settings().id != 0) json["id"] = state.link->settings().id;
    else json["id"] = nullptr;
    json["state"] = state.up ? "up" : "waiting";
    json["since_s"] = in_seconds(now - state.since);
    put(json, report.error);
    json["hint"] = hint.text;
    json["hint_id"] = hint.id;
    json["hint_args"] = args_json(hint);
    for (const auto& fact : state.link->facts())
        std::visit([&](const auto& v) { json[std::string{fact.first}] = v; }, fact.second);
    if (state.link->settings().attitude == ano::EulerSigns::lx) json["attitude"] = "lx";
    if (state.link->settings().required) json["required"] = true;
    if (!state.link->settings().group.empty()) json["group"] = state.link->settings().group;
    const LinkTraffic& traffic = gateway.forwarder().traffic(state.link->id());
    if (traffic.replayed.any()) json["replayed"] = replayed_json(traffic.replayed);
    json["channels"] = Json::array();
    for (const ChannelId id : traffic.channels)
        json["channels"].push_back(channel_json(gateway.forwarder().channel(id), *state.link, now));
    put(json, report.figures.received, report.figures.sent, report.waiting);
    if (report.figures.longest_image > 0) json["longest_image"] = report.figures.longest_image;
    return json;
}

Json names(const Gateway& gateway, LinkSet links) {
    Json json = Json::array();
    for (const LinkId id : links) json.push_back(gateway.link(id).name());
    return json;
}

Json routes_array(const Gateway& gateway, TimePoint now) {
    Json json = Json::array();
    for (const RouteRow& row : route_rows(gateway, now)) {
        json.push_back({{"address", ano::hex_byte(row.address)}, {"who", ano::address::who(row.address)}});
        json.back()["links"] = names(gateway, row.links);
        json.back()["via"] = text(row.via);
        if (row.heard_at) json.back()["age_s"] = in_seconds(now - *row.heard_at);
        const LinkSet before = gateway.forwarder().router().moved_from(row.address);
        if (row.via == Via::learned && !before.empty()) json.back()["moved_from"] = names(gateway, before);
    }
    return json;
}

Json conflicts_json(const Gateway& gateway, TimePoint now) {
    Json json = Json::array();
    for (const Conflict& c : gateway.forwarder().router().conflicts(now)) {
        json.push_back({{"address", ano::hex_byte(c.address)}, {"links", names(gateway, c.links)}, {"count", c.count}});
        Json& by = json.back()["claimed_by"] = nullptr;
        if (const Forwarder::Claimant* claimant = gateway.forwarder().claimant(c))
            by = {{"link", gateway.link(claimant->link).name()}, {"peer", claimant->peer}};
        const Router& router = gateway.forwarder().router();
        const LinkSet pinned = router.pinned(c.address);
        json.back()["home"] = names(gateway, pinned.empty() ? router.learned(c.address, now).links : pinned);
        json.back()["pinned"] = !pinned.empty();
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
    json["decoding_changes"] = gateway.layouts().changes();
    json["own_frames"] = gateway.forwarder().router().own_frames();
    json["config"] = config_json(gateway.config_state(), now);
    for (const GatewayEvents* part : gateway.parts().listeners) part->describe_gateway(json);
    return json;
}

// Waiting connections come first: that hint ends within minutes.
Hint hint_of(const ListenerInfo& listener) {
    if (listener.evicted_lately) return waiting_connections_closed();
    const CertificateValidity& validity = listener.validity;
    std::string text = validity.warning("the certificate of control.tls");
    if (text.empty()) return {};
    text += ", then run anoctl reload";
    if (!validity.has_begun) return {"certificate_not_valid_yet", std::move(text)};
    return {"certificate_expires", std::move(text), {{"days", *validity.days_left}}};
}

Json http_json(const ListenerInfo& listener) {
    Json json;
    json["state"] = text(listener.state);
    if (listener.state == ListenerInfo::State::off) return json;
    json["error"] = listener.error;
    json["address"] = listener.address;
    json["port"] = listener.port;
    json["tls"] = listener.is_encrypted;
    if (listener.is_encrypted) json["certificate"] = listener.certificate;
    if (listener.validity.days_left) json["certificate_days"] = *listener.validity.days_left;
    json["token_needed"] = listener.needs_token;
    if (!listener.token_file.empty()) json["token_file"] = listener.token_file;
    json["hosts"] = listener.hosts;
    json["wrong_tokens"] = listener.wrong_tokens;
    json["guessing_clients"] = listener.guessing_clients;
    json["gave_way"] = listener.evicted;
    const Hint hint = hint_of(listener);
    json["hint_id"] = hint.id;
    json["hint"] = hint.text;
    json["hint_args"] = args_json(hint);
    json["codes"] = {{"link", listener.link_code}, {"digits", listener.digits_code}};
    return json;
}

/// null if no map is configured.
Json map_json(const MapSettings& map) {
    if (map.file.empty()) return nullptr;
    return {{"file", map.file}, {"datum", map.datum == Datum::gcj02 ? "gcj02" : "wgs84"}};
}

Json tunnel_json(const Gateway& gateway) {
    Json json = Json::object();
    if (const TunnelLink* tunnel = gateway.tunnel())
        for (const auto& row : tunnel_counters) json[std::string{row.name}] = tunnel->counters().*row.value;
    return json;
}

Json links_array(const Gateway& gateway, TimePoint now) {
    Json json = Json::array();
    for (const LinkState& state : gateway.links()) json.push_back(link_json(gateway, state, now));
    return json;
}

Json recording_json(const Gateway& gateway) {
    Json json;    // null: there are no recordings
    if (RecordingService* const recording = gateway.parts().recording) recording->describe(json);
    return json;
}

}    // namespace

std::string status_json(Gateway& gateway, const ListenerInfo& listener, const Json* lost) {
    const TimePoint now = gateway.now();
    Json json = object_with_room(11);
    json["gateway"] = gateway_json(gateway, now);
    json["links"] = links_array(gateway, now);
    json["routes"] = routes_array(gateway, now);
    json["conflicts"] = conflicts_json(gateway, now);
    json["tunnel"] = tunnel_json(gateway);
    json["gpio"] = gpio_json(gateway.gpio(), now);
    json["recording"] = recording_json(gateway);
    json["http"] = http_json(listener);
    if (lost) json["lost"] = *lost;
    json["map"] = map_json(gateway.settings().control.map);
    return line_of(std::move(json));
}

std::string messages_json(const Gateway& gateway) { return line_of(ano::describe_all(gateway.decoding()->layouts())); }

std::string links_json(Gateway& gateway) { return line_of(links_array(gateway, gateway.now())); }
std::string routes_json(Gateway& gateway) { return line_of(routes_array(gateway, gateway.now())); }

std::string status_text(Gateway& gateway) {
    const TimePoint now = gateway.now();
    std::string text;
    for (const LinkState& state : gateway.links()) {
        const LinkReport t = report_of(gateway, state, now);
        text += state.link->name() + (state.up ? ": up" : ": waiting: " + state.error.text);
        text += ", in " + std::to_string(t.figures.received.frames_in) + ", out " + std::to_string(t.figures.sent.frames_out);
        if (!t.hint.text.empty()) text += " (" + t.hint.text + ")";
        text += "\n";
    }
    return text;
}

FrameCount frame_count(const Gateway& gateway) {
    FrameCount count;
    for (const LinkState& state : gateway.links()) {
        const LinkFigures figures = report_of(gateway, state, {}).figures;
        count.in += figures.received.frames_in;
        count.out += figures.sent.frames_out;
    }
    return count;
}

std::vector<std::string> HintLog::news(Gateway& gateway) {
    const TimePoint now = gateway.now();
    std::vector<std::string> lines;
    for (const LinkState& state : gateway.links()) {
        std::set<std::string>& logged = logged_hints_[state.link->name()];
        if (!state.up) logged.clear();
        const LinkError error = state.up ? state.link->trouble() : LinkError{};
        const bool is_of_recording = error.id == "recording_damaged" ||
                                     error.id == "nothing_to_replay";    // logged besides hints
        for (const std::string& words :
             {is_of_recording ? error.text : std::string{}, hint_of_trouble(report_of(gateway, state, now).figures)})
            if (!words.empty() && logged.insert(words).second) lines.push_back(state.link->name() + ": " + words);
    }
    return lines;
}

}    // namespace anogate
