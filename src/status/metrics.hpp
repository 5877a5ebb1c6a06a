// The metrics of a gateway for Prometheus. Their names are those of the counters; config/prometheus/README.md lists the others.
#pragma once
#include <ano/time.hpp>
#include <gateway/counters.hpp>
#include <gateway/v7_translation.hpp>
#include <runtime/recording_figures.hpp>
#include <status/metrics_text.hpp>
#include <sys/process_figures.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

class Gateway;

/// The values of the metrics at one moment. There is a series for each link and each open channel: at most 64 of each.
struct MetricsSnapshot {
    struct Traffic {
        ReceiveCounters received;
        SendCounters sent;
        std::uint64_t waiting = 0;
    };
    struct Channel {
        std::string peer;
        std::optional<double> silent_s;    // seconds since its last valid frame; std::nullopt: there was none
        Traffic traffic;
    };
    struct Link {
        std::string name, kind, id;    // id: the port id, or empty
        bool up = false;
        double since_s = 0;                                 // time since the last change of `up`
        std::string_view hint_id;                           // empty: none
        std::optional<std::int64_t> certificate_days;       // of a TLS link: days until its certificate expires
        std::optional<std::uint64_t> evicted_handshakes;    // of a link that listens with TLS
        std::optional<V7Counters> v7;                       // of a link with protocol V7
        Traffic traffic;
        std::vector<Channel> channels;
    };

    std::string version;
    double uptime_s = 0;
    std::uint64_t standstills = 0;
    double longest_standstill_s = 0;
    std::uint64_t own_frames = 0;
    std::vector<std::pair<std::string_view, std::uint64_t>> routes;    // deciding rule, number of addresses
    std::uint64_t conflicts = 0;
    std::uint64_t wrong_tokens = 0, guessing_clients = 0, evicted = 0;    // of control.http, see ListenerInfo
    std::optional<std::int64_t> certificate_days;                         // of control.tls
    std::uint64_t amber_alarms = 0, red_alarms = 0;                       // values beyond their limits
    std::vector<Link> links;
    std::optional<TunnelCounters> tunnel;
    std::optional<RecordingFigures> recording;
    ProcessFigures process;
};

MetricsSnapshot metrics_snapshot(const Gateway& gateway, ano::TimePoint now);

/// The text of `snapshot`. All series have different labels, even if links or peers have the same name.
std::string metrics(MetricsSnapshot snapshot, MetricsForm form);

}    // namespace anogate
