#include <status/metrics.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

namespace anogate::metrics_tests {
namespace {

MetricsSnapshot::Link link_called(std::string name, std::vector<std::string> peers = {}) {
    MetricsSnapshot::Link link;
    link.name = std::move(name);
    link.kind = "udp-listen";
    for (std::string& peer : peers) link.channels.emplace_back().peer = std::move(peer);
    return link;
}

std::vector<std::string> samples(const std::string& text) {
    std::vector<std::string> all;
    std::istringstream lines{text};
    for (std::string line; std::getline(lines, line);)
        if (!line.starts_with('#')) all.push_back(line);
    return all;
}
bool has(const std::string& text, const std::string& line) {
    const auto all = samples(text);
    return std::find(all.begin(), all.end(), line) != all.end();
}

TEST(Metrics, has_every_counter_of_links_and_channels) {
    MetricsSnapshot snapshot;
    snapshot.links.push_back(link_called("ground", {"10.0.0.1:5"}));
    std::uint64_t value = 1;
    const auto fill = [&](MetricsSnapshot::Traffic& traffic) {
        for (const auto& row : receive_counters) traffic.received.*row.value = value++;
        for (const auto& row : send_counters) traffic.sent.*row.value = value++;
        traffic.waiting = value++;
    };
    fill(snapshot.links[0].traffic);
    fill(snapshot.links[0].channels[0].traffic);
    snapshot.tunnel.emplace();
    for (const auto& row : tunnel_counters) *snapshot.tunnel.*row.value = value++;
    const std::string text = metrics(snapshot, MetricsForm::prometheus);

    value = 1;
    const auto expect = [&](const std::string& kind, const std::string& labels) {
        const auto counter = [&](std::string_view name) {
            const std::string line = "anogate_" + kind + "_" + std::string{name} + "_total" + labels + " " +
                                     std::to_string(value++);
            EXPECT_TRUE(has(text, line)) << line;
        };
        for (const auto& row : receive_counters) counter(row.name);
        for (const auto& row : send_counters) counter(row.name);
        EXPECT_TRUE(has(text, "anogate_" + kind + "_waiting_frames" + labels + " " + std::to_string(value++)));
    };
    expect("link", "{link=\"ground\"}");
    expect("channel", "{link=\"ground\",peer=\"10.0.0.1:5\"}");
    for (const auto& row : tunnel_counters) {
        const std::string name{row.name.starts_with("tunnel_") ? row.name.substr(7) : row.name};
        const std::string line = "anogate_tunnel_" + name + "_total " + std::to_string(value++);
        EXPECT_TRUE(has(text, line)) << line;
    }
}

TEST(Metrics, has_the_state_of_links_and_of_the_gateway) {
    MetricsSnapshot snapshot;
    snapshot.version = "1.2.3";
    snapshot.uptime_s = 12.5;
    snapshot.conflicts = 2;
    snapshot.evicted = 5;
    snapshot.certificate_days = 3;
    snapshot.routes = {{"own", 1}, {"learned", 3}};
    snapshot.links = {link_called("fc", {""}), link_called("ground")};
    snapshot.links[0].up = true;
    snapshot.links[0].id = "7";
    snapshot.links[0].since_s = 3;
    snapshot.links[0].hint_id = "silent";
    snapshot.links[0].certificate_days = 13;
    snapshot.links[0].evicted_handshakes = 7;
    snapshot.links[0].channels[0].silent_s = 4.5;
    snapshot.process.open_fds = 9;
    const std::string text = metrics(snapshot, MetricsForm::prometheus);
    for (const char* line :
         {"anogate_build_info{version=\"1.2.3\"} 1", "anogate_uptime_seconds 12.5", "anogate_conflicts 2",
          "anogate_connections_gave_way_total 5", "anogate_http_certificate_expires_seconds 259200",
          "anogate_routes{via=\"own\"} 1", "anogate_routes{via=\"learned\"} 3",
          "anogate_link_info{link=\"fc\",kind=\"udp-listen\",id=\"7\"} 1", "anogate_link_up{link=\"fc\"} 1",
          "anogate_link_up{link=\"ground\"} 0", "anogate_link_state_seconds{link=\"fc\"} 3",
          "anogate_link_channels{link=\"fc\"} 1", "anogate_link_certificate_expires_seconds{link=\"fc\"} 1123200",
          "anogate_link_handshakes_gave_way_total{link=\"fc\"} 7", "anogate_link_hint{link=\"fc\",hint=\"silent\"} 1",
          "anogate_channel_silent_seconds{link=\"fc\",peer=\"\"} 4.5", "process_open_fds 9"})
        EXPECT_TRUE(has(text, line)) << line;
    EXPECT_EQ(text.find("hint{link=\"ground\""), std::string::npos);
    EXPECT_EQ(text.find("anogate_tunnel"), std::string::npos) << "there is none";
}

TEST(Metrics, has_the_counters_of_the_translation_for_v7_links) {
    MetricsSnapshot snapshot;
    snapshot.links = {link_called("fc"), link_called("ground")};
    V7Counters& counters = snapshot.links[0].v7.emplace();
    std::uint64_t value = 100;
    for (const V7CounterRow& row : v7_counters) counters.*row.value = value++;
    const std::string text = metrics(snapshot, MetricsForm::prometheus);
    value = 100;
    for (const V7CounterRow& row : v7_counters) {
        const std::string line = "anogate_link_" + std::string{row.name} + "_total{link=\"fc\"} " + std::to_string(value++);
        EXPECT_TRUE(has(text, line)) << line;
    }
    EXPECT_EQ(text.find("v7_up_total{link=\"ground\"}"), std::string::npos);
}

TEST(Metrics, has_no_series_twice_for_any_names) {
    MetricsSnapshot snapshot;
    snapshot.links = {link_called("a\xFF", {"p", "p", "p-2"}), link_called("a\xFE"), link_called("a\xEF\xBF\xBD-2")};
    for (const MetricsForm form : {MetricsForm::prometheus, MetricsForm::openmetrics}) {
        std::set<std::string> seen;
        for (const std::string& line : samples(metrics(snapshot, form)))
            EXPECT_TRUE(seen.insert(line.substr(0, line.rfind(' '))).second) << line;
        EXPECT_EQ(std::count_if(seen.begin(), seen.end(), [](const auto& s) { return s.starts_with("anogate_link_up{"); }), 3);
    }
}

// A gateway has at most 64 links and 64 channels.
TEST(Metrics, has_a_bounded_number_of_series) {
    MetricsSnapshot snapshot;
    for (int i = 0; i < 64; ++i)
        snapshot.links.push_back(link_called("link" + std::to_string(i), {"192.168.100.100:" + std::to_string(10000 + i)}));
    const std::string text = metrics(snapshot, MetricsForm::prometheus);
    EXPECT_LT(samples(text).size(), 4000u);
    EXPECT_LT(text.size(), 300u * 1024);
}

TEST(Metrics, of_one_family_are_grouped_together) {
    MetricsSnapshot snapshot;
    snapshot.links = {link_called("a", {"1", "2"}), link_called("b", {"3"})};
    std::set<std::string> done;
    std::string now;
    for (const std::string& line : samples(metrics(snapshot, MetricsForm::prometheus))) {
        const std::string name = line.substr(0, line.find_first_of("{ "));
        if (name == now) continue;
        EXPECT_TRUE(done.insert(name).second) << name << " comes again";
        now = name;
    }
}

}    // namespace
}    // namespace anogate::metrics_tests
