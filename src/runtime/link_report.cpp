#include <ano/address.hpp>
#include <ano_json/text.hpp>
#include <config/link_kind.hpp>
#include <runtime/conflict_log.hpp>
#include <runtime/gateway.hpp>
#include <runtime/link_report.hpp>

#include <algorithm>
#include <bitset>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {
namespace {

LinkHints with_v7(LinkHints words) {
    words.no_frames = {"no_v7_frames",
                       "data but no valid V7 frames: check the baud rate; if the device uses V8, remove protocol=v7"};
    words.no_frames_any_more = {"no_v7_frames_any_more", ": check the baud rate and the protocol of the device"};
    return words;
}

// Of several conflicts of the link, shows the one that is easiest to fix.
void set_shared(LinkFigures& f, const Gateway& gateway, const std::vector<Conflict>& conflicts, LinkId link) {
    const auto rank = [](SharedSource one) {
        return one == SharedSource::two_peers       ? 5
               : one == SharedSource::of_a_group    ? 4
               : one == SharedSource::one_device    ? 3
               : one == SharedSource::two_devices   ? 2
               : one == SharedSource::claims_pinned ? 1
                                                    : 0;
    };
    for (const Conflict& c : conflicts) {
        const SharedSource meaning = meaning_of(gateway, c);
        if (!c.links.contains(link) || rank(meaning) <= rank(f.shared)) continue;
        f.shared = meaning;
        f.shared_address = c.address;
    }
}

// The link, and all links connected with it by conflicts: the explanation of a conflict is shown at each of its links.
LinkSet joined_by(const std::vector<Conflict>& conflicts, LinkId link) {
    LinkSet all;
    all.insert(link);
    for (LinkSet before; before != all;) {
        before = all;
        for (const Conflict& c : conflicts)
            if (!(c.links & all).empty()) all |= c.links;
    }
    return all;
}

// Of several loops, shows the last.
void set_ring(LinkFigures& f, const Gateway& gateway, LinkSet links, TimePoint now) {
    for (const ChannelId id : gateway.forwarder().channels()) {
        if (!links.contains(gateway.forwarder().channel(id).link)) continue;
        const auto ring = gateway.forwarder().loops().loop(id, now);
        if (!ring) continue;
        f.ring_out = gateway.link(ring->out).name();
        f.ring_back = gateway.link(ring->back).name();
    }
}

// The address of a device that was unknown when a frame was sent to it; std::nullopt: it is known by now.
std::optional<std::uint8_t> still_unknown(const Gateway& gateway, std::optional<std::uint8_t> address, TimePoint now) {
    const bool is_known = address && !gateway.forwarder().router().learned(*address, now).links.empty();
    return is_known ? std::nullopt : address;
}

// A device on this link whose frames are sent to another link, because the port id of that link equals the id of the device.
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

bool has_heard_host(const Gateway& gateway, LinkId link) {
    const Router& router = gateway.forwarder().router();
    for (const ChannelId channel : gateway.forwarder().traffic(link).channels)
        if (router.heard_at(ano::address::host, channel) || router.heard_at(ano::address::ros_bridge, channel)) return true;
    return false;
}

bool has_device(const Gateway& gateway, LinkId link) {
    const std::bitset<256> homes = gateway.forwarder().router().last_homes(link);
    for (std::size_t address = 0; address < homes.size(); ++address)
        if (homes[address] && !ano::address::is_host(static_cast<std::uint8_t>(address))) return true;
    return false;
}

// A likely configuration mistake although the link works: shown as a hint, not as an error.
bool is_hint(const LinkError& trouble) {
    return trouble.id == "shared_port" || trouble.id == "other_adapter" || trouble.id == "twin_adapter";
}

Hint hint_of(LinkError trouble) {
    Hint hint{trouble.id, std::move(trouble.text), {}};
    for (auto& [name, value] : trouble.arguments) hint.args.emplace_back(name, std::move(value));
    return hint;
}

void add_hint(LinkReport& report, const LinkState& state) {
    LinkError trouble = state.up ? state.link->trouble() : state.error;
    if (state.up && is_hint(trouble)) {
        report.hint = hint_of(std::move(trouble));
    } else {
        report.error = std::move(trouble);
        report.hint = find_hint(report.figures);
    }
}

}    // namespace

LinkReport report_of(const Gateway& gateway, const LinkState& state, TimePoint now) {
    LinkReport report;
    const LinkTraffic& traffic = gateway.forwarder().traffic(state.link->id());
    LinkFigures& f = report.figures;
    f.words = state.link->settings().kind->hints;
    if (uses_v7(state.link->settings())) f.words = with_v7(f.words);
    f.up = state.up;
    f.to_utf8 = [](std::span<const std::uint8_t> text) {
        try {
            return ano::to_utf8(text, ano::Encoding::automatic);
        } catch (const std::runtime_error&) {    // this system can't convert GBK
            return std::string{};
        }
    };
    if (const PlayedRecording* played = state.link->as<PlayedRecording>()) f.is_over = played->is_over();
    f.is_exclusive = gateway.forwarder().is_exclusive(state.link->id());
    f.listens = state.link->settings().kind->listens;
    f.has_connections = f.listens && state.link->settings().kind->carries == Carries::bytes;
    f.channels = traffic.channels.size();
    f.could_send_hello = !f.listens && hello_interval(state.link->settings()) == Duration{};
    f.for_hosts = (leads_hosts_to(gateway.settings(), state.link->name()) || has_heard_host(gateway, state.link->id())) &&
                  !has_device(gateway, state.link->id());
    f.up_for = now - state.since;
    f.undelivered_for = traffic.undelivered.duration(now);
    f.hosts_link = link_of_lost_hosts(gateway);
    const std::vector<Conflict> conflicts = gateway.forwarder().router().conflicts(now);
    set_shared(f, gateway, conflicts, state.link->id());
    set_ring(f, gateway, joined_by(conflicts, state.link->id()), now);
    f.not_sent = still_unknown(gateway, traffic.not_sent.lately(now), now);
    f.answers_for_others = traffic.answers_for_others.lately(now);
    f.nobody = traffic.nobody.lately(now);
    f.hidden = hidden_device(gateway, state.link->id(), now);
    f.contradictory = traffic.attitudes.contradictory();
    f.attitude = traffic.attitudes.signs();
    f.received = traffic.gone_received;
    f.sent = traffic.gone_sent;
    f.came_stale = traffic.came_stale;
    const UnassignedReceiver* const receiver = state.link->as<UnassignedReceiver>();
    const UnassignedTraffic unassigned = receiver ? receiver->unassigned_traffic() : UnassignedTraffic{};
    add(f.received, unassigned.received);
    f.v7_frames = unassigned.v7_frames;
    f.may_use_v7 = may_use_v7(*state.link->settings().kind);
    if (unassigned.parser) add_skipped(f, *unassigned.parser);
    f.gateways = unassigned.gateways;
    f.no_place = unassigned.no_place;
    f.no_memory = unassigned.no_memory;
    f.outsiders = unassigned.outsiders;
    f.handshakes = unassigned.handshakes;
    f.without_frame = unassigned.without_frame;
    for (const ChannelId id : traffic.channels) {
        const Channel& channel = gateway.forwarder().channel(id);
        add(f.received, channel.received());
        add(f.sent, channel.sent());
        f.echoes = f.echoes || channel.echo.echoes(now) || V7Notes::is_recent(channel.v7.echo, now);
        f.v7_loops = f.v7_loops || V7Notes::is_recent(channel.v7.loop, now);
        f.v7_commands = f.v7_commands || V7Notes::is_recent(channel.v7.command, now);
        f.v7_frames += channel.parser.counters().v7_frames;
        f.long_images += channel.parser.counters().long_images;
        f.longest_image = std::max(f.longest_image, channel.parser.longest_image());
        add_skipped(f, channel.parser);
        if (channel.parser.counters().skipped_bytes > 0)
            f.frames_since_skipped = std::min(f.frames_since_skipped.value_or(UINT64_MAX), channel.parser.frames_since_skipped());
        f.skipped_since += channel.skipped_since_heard();
        report.waiting += channel.waiting();
        if (channel.arrived_at != TimePoint{})
            f.bytes_ago = std::min(f.bytes_ago.value_or(Duration::max()), now - channel.arrived_at);
        if (channel.heard_at == TimePoint{}) continue;
        f.silent_for = std::min(f.silent_for.value_or(Duration::max()), now - channel.heard_at);
    }
    add_hint(report, state);
    return report;
}

}    // namespace anogate
