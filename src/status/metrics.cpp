#include <ano/address.hpp>
#include <ano_json/answer_json.hpp>
#include <ano_json/text.hpp>
#include <config/link_kind.hpp>
#include <runtime/gateway.hpp>
#include <runtime/link_report.hpp>
#include <runtime/route_rows.hpp>
#include <status/metrics.hpp>

#include <algorithm>
#include <iterator>
#include <set>

namespace anogate {
namespace {

using Traffic = MetricsSnapshot::Traffic;

std::string utf8(const std::string& name) {
    return ano::to_utf8({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()}, ano::Encoding::utf8);
}

/// `name` as valid UTF-8, with a number appended if it is in `taken`; the result is added to `taken`.
std::string made_unique(const std::string& name, std::set<std::string>& taken) {
    const std::string text = utf8(name);
    std::string one = text;
    for (int number = 2; !taken.insert(one).second; ++number) one = text + "-" + std::to_string(number);
    return one;
}

void make_labels_unique(MetricsSnapshot& snapshot) {
    std::set<std::string> links;
    for (MetricsSnapshot::Link& link : snapshot.links) {
        link.name = made_unique(link.name, links);
        std::set<std::string> peers;
        for (MetricsSnapshot::Channel& channel : link.channels) channel.peer = made_unique(channel.peer, peers);
    }
}

/// Calls `visit` for every counter, with its name, its help text and a function that returns its value from a Traffic.
template <class Visit>
void each_counter(Visit visit) {
    for (const auto& row : receive_counters)
        visit(row.name, row.help, [&row](const Traffic& traffic) { return traffic.received.*row.value; });
    for (const auto& row : send_counters)
        visit(row.name, row.help, [&row](const Traffic& traffic) { return traffic.sent.*row.value; });
}

void write_gateway(MetricsText& text, const MetricsSnapshot& s) {
    text.family("anogate_build", MetricType::info, "the running program");
    text.sample({{"version", s.version}}, std::uint64_t{1});
    text.family("anogate_uptime_seconds", MetricType::gauge, "since the gateway started");
    text.sample({}, s.uptime_s);
    text.family("anogate_standstills", MetricType::counter, "number of stalls of the main loop");
    text.sample({}, s.standstills);
    text.family("anogate_longest_standstill_seconds", MetricType::gauge, "longest stall of the main loop");
    text.sample({}, s.longest_standstill_s);
    text.family("anogate_own_frames", MetricType::counter, "frames to the address of the gateway itself");
    text.sample({}, s.own_frames);
    text.family("anogate_routes", MetricType::gauge, "known addresses, by routing rule");
    for (const auto& [via, count] : s.routes) text.sample({{"via", via}}, count);
    text.family("anogate_conflicts", MetricType::gauge, "addresses claimed by several devices");
    text.sample({}, s.conflicts);
    text.family("anogate_wrong_tokens", MetricType::counter, "wrong tokens received by control.http");
    text.sample({}, s.wrong_tokens);
    text.family("anogate_guessing_clients", MetricType::counter, "clients of control.http delayed because of wrong tokens");
    text.sample({}, s.guessing_clients);
    text.family("anogate_connections_gave_way", MetricType::counter,
                "connections to control.http that waited and were closed because others came");
    text.sample({}, s.evicted);
    text.family("anogate_http_certificate_expires_seconds", MetricType::gauge,
                "whole days until the certificate of control.tls expires; negative: expired");
    if (s.certificate_days) text.sample({}, static_cast<double>(*s.certificate_days) * 86400);
    text.family("anogate_alarms", MetricType::gauge, "device values outside their alarm limits");
    text.sample({{"level", "amber"}}, s.amber_alarms);
    text.sample({{"level", "red"}}, s.red_alarms);
}

void write_state(MetricsText& text, const MetricsSnapshot& s) {
    text.family("anogate_link", MetricType::info, "the links of the configuration; id is the port id");
    for (const auto& link : s.links) text.sample({{"link", link.name}, {"kind", link.kind}, {"id", link.id}}, std::uint64_t{1});
    text.family("anogate_link_up", MetricType::gauge, "1: up; 0: waiting");
    for (const auto& link : s.links) text.sample({{"link", link.name}}, std::uint64_t{link.up});
    text.family("anogate_link_state_seconds", MetricType::gauge, "how long the link has been up or down");
    for (const auto& link : s.links) text.sample({{"link", link.name}}, link.since_s);
    text.family("anogate_link_channels", MetricType::gauge, "channels of the link; a listening link has one per peer");
    for (const auto& link : s.links) text.sample({{"link", link.name}}, std::uint64_t{link.channels.size()});
    text.family("anogate_link_certificate_expires_seconds", MetricType::gauge,
                "whole days until the certificate of a TLS link expires; negative: expired");
    for (const auto& link : s.links)
        if (link.certificate_days) text.sample({{"link", link.name}}, static_cast<double>(*link.certificate_days) * 86400);
    text.family("anogate_link_handshakes_gave_way", MetricType::counter,
                "connections closed in favor of others during the TLS handshake");
    for (const auto& link : s.links)
        if (link.evicted_handshakes) text.sample({{"link", link.name}}, *link.evicted_handshakes);
    text.family("anogate_link_hint", MetricType::gauge, "1: the current hint of the status, as hint_id");
    for (const auto& link : s.links)
        if (!link.hint_id.empty()) text.sample({{"link", link.name}, {"hint", link.hint_id}}, std::uint64_t{1});
}

void write_links(MetricsText& text, const MetricsSnapshot& s) {
    text.family("anogate_link_waiting_frames", MetricType::gauge, "frames waiting to be sent");
    for (const auto& link : s.links) text.sample({{"link", link.name}}, link.traffic.waiting);
    each_counter([&](std::string_view name, std::string_view help, const auto& count) {
        text.family("anogate_link_" + std::string{name}, MetricType::counter, help);
        for (const auto& link : s.links) text.sample({{"link", link.name}}, count(link.traffic));
    });
}

void write_v7(MetricsText& text, const MetricsSnapshot& s) {
    for (const V7CounterRow& row : v7_counters) {
        text.family("anogate_link_" + std::string{row.name}, MetricType::counter, row.help);
        for (const auto& link : s.links)
            if (link.v7) text.sample({{"link", link.name}}, *link.v7.*row.value);
    }
}

void write_channels(MetricsText& text, const MetricsSnapshot& s) {
    const auto each_channel = [&](auto visit) {
        for (const auto& link : s.links)
            for (const auto& channel : link.channels) visit(link, channel);
    };
    text.family("anogate_channel_silent_seconds", MetricType::gauge, "time since the last valid frame");
    each_channel([&](const auto& link, const auto& channel) {
        if (channel.silent_s) text.sample({{"link", link.name}, {"peer", channel.peer}}, *channel.silent_s);
    });
    text.family("anogate_channel_waiting_frames", MetricType::gauge, "frames waiting to be sent");
    each_channel([&](const auto& link, const auto& channel) {
        text.sample({{"link", link.name}, {"peer", channel.peer}}, channel.traffic.waiting);
    });
    each_counter([&](std::string_view name, std::string_view help, const auto& count) {
        text.family("anogate_channel_" + std::string{name}, MetricType::counter, help);
        each_channel([&](const auto& link, const auto& channel) {
            text.sample({{"link", link.name}, {"peer", channel.peer}}, count(channel.traffic));
        });
    });
}

void write_recording(MetricsText& text, const RecordingFigures& figures) {
    const auto one = [&text](std::string_view name, MetricType type, std::string_view help, std::uint64_t value) {
        text.family(name, type, help);
        text.sample({}, value);
    };
    using enum MetricType;
    one("anogate_recording_running", gauge, "recordings in progress", figures.running);
    one("anogate_recording_failing", gauge, "recordings in progress that are losing frames; the status has the reason",
        figures.failing);
    one("anogate_recording_frames", counter, "frames written to recordings", figures.frames);
    one("anogate_recording_written_bytes", counter, "bytes written to recordings", figures.bytes);
    one("anogate_recording_not_written", counter, "frames missing in recordings because they could not be written",
        figures.not_written);
    if (figures.free) one("anogate_recording_disk_free_bytes", gauge, "free space on the disk of the recordings", *figures.free);
    one("anogate_recording_memory_frames", gauge, "frames in keep_last", figures.memory_frames);
    one("anogate_recording_memory_bytes", gauge, "memory used by keep_last", figures.memory_bytes);
    one("anogate_recording_saved", counter, "number of times keep_last was saved", figures.saved);
    one("anogate_recording_skipped", counter, "number of times keep_last was not saved because it had been within a minute",
        figures.skipped);
}

void write_tunnel(MetricsText& text, const TunnelCounters& counters) {
    for (const auto& row : tunnel_counters) {
        std::string_view name = row.name;
        if (name.starts_with("tunnel_")) name.remove_prefix(std::string_view{"tunnel_"}.size());
        text.family("anogate_tunnel_" + std::string{name}, MetricType::counter, row.help);
        text.sample({}, counters.*row.value);
    }
}

// Uses the usual names of Prometheus clients.
void write_process(MetricsText& text, const ProcessFigures& process) {
    text.family("process_cpu_seconds", MetricType::counter, "user and system CPU time");
    text.sample({}, process.cpu_s);
    text.family("process_resident_memory_bytes", MetricType::gauge, "resident memory");
    text.sample({}, process.resident_bytes);
    text.family("process_virtual_memory_bytes", MetricType::gauge, "virtual memory");
    text.sample({}, process.virtual_bytes);
    text.family("process_start_time_seconds", MetricType::gauge, "start time as Unix time");
    text.sample({}, process.started_at_s);
    if (process.open_fds) {
        text.family("process_open_fds", MetricType::gauge, "open file descriptors");
        text.sample({}, *process.open_fds);
    }
    text.family("process_max_fds", MetricType::gauge, "maximum number of open file descriptors");
    text.sample({}, process.max_fds);
}

const V7CounterRow* find_v7_counter(std::string_view name) {
    const auto* const found = std::find_if(std::begin(v7_counters), std::end(v7_counters),
                                           [&](const auto& row) { return row.name == name; });
    return found == std::end(v7_counters) ? nullptr : found;
}

MetricsSnapshot::Link snapshot_of(const Gateway& gateway, const LinkState& state, TimePoint now) {
    const LinkReport report = report_of(gateway, state, now);
    const LinkSettings& settings = state.link->settings();
    MetricsSnapshot::Link link;
    link.name = state.link->name();
    link.kind = settings.kind->name;
    if (settings.id != 0) link.id = std::to_string(settings.id);
    link.up = state.up;
    link.since_s = in_seconds(now - state.since);
    link.hint_id = report.hint.id;
    for (const auto& [name, value] : state.link->facts())
        if (name == "certificate_days") link.certificate_days = std::get<std::int64_t>(value);
        else if (name == "handshakes_gave_way")
            link.evicted_handshakes = static_cast<std::uint64_t>(std::get<std::int64_t>(value));
        else if (const V7CounterRow* row = find_v7_counter(name)) {
            if (!link.v7) link.v7.emplace();
            (*link.v7).*row->value = static_cast<std::uint64_t>(std::get<std::int64_t>(value));
        }
    link.traffic = {report.figures.received, report.figures.sent, report.waiting};
    for (const ChannelId id : gateway.forwarder().traffic(state.link->id()).channels) {
        const Channel& channel = gateway.forwarder().channel(id);
        auto& entry = link.channels.emplace_back();
        entry.peer = channel.peer;
        if (channel.heard_at != TimePoint{}) entry.silent_s = in_seconds(now - channel.heard_at);
        entry.traffic = {channel.received(), channel.sent(), channel.waiting()};
    }
    return link;
}

}    // namespace

MetricsSnapshot metrics_snapshot(const Gateway& gateway, TimePoint now) {
    MetricsSnapshot s;
    s.version = ANOGATE_VERSION;
    s.uptime_s = in_seconds(now - gateway.started_at());
    s.standstills = gateway.loop().standstills();
    s.longest_standstill_s = in_seconds(gateway.loop().longest());
    s.own_frames = gateway.forwarder().router().own_frames();
    for (const Via via : {Via::own, Via::port, Via::pinned, Via::learned}) s.routes.emplace_back(text(via), 0);
    for (const RouteRow& row : route_rows(gateway, now))
        for (auto& [via, count] : s.routes)
            if (via == text(row.via)) ++count;
    s.conflicts = gateway.forwarder().router().conflicts(now).size();
    for (const LinkState& state : gateway.links()) s.links.push_back(snapshot_of(gateway, state, now));
    if (const TunnelLink* tunnel = gateway.tunnel()) s.tunnel = tunnel->counters();
    if (RecordingService* const recording = gateway.parts().recording) s.recording = recording->figures();
    s.process = this_process();
    return s;
}

std::string metrics(MetricsSnapshot snapshot, MetricsForm form) {
    make_labels_unique(snapshot);
    MetricsText text{form};
    write_gateway(text, snapshot);
    write_state(text, snapshot);
    write_links(text, snapshot);
    write_v7(text, snapshot);
    write_channels(text, snapshot);
    if (snapshot.tunnel) write_tunnel(text, *snapshot.tunnel);
    if (snapshot.recording) write_recording(text, *snapshot.recording);
    write_process(text, snapshot.process);
    return text.finish();
}

}    // namespace anogate
