// GET /status: its format is a public interface, and its hints are the first thing that a user reads.
#include <link/link_error.hpp>
#include <status/status.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace status_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using nlohmann::json;

const char* const counters[] = {
    "frames_in", "bytes_in",   "bad_check",  "bad_length", "skipped_bytes", "expired",     "denied_in",  "inhibited",  "looped",
    "duplicate", "no_route",   "frames_out", "bytes_out",  "empty_out",     "flush_bytes", "superseded", "queue_full", "stale",
    "limited",   "denied_out", "link_down",  "too_big",    "send_failed",   "held_back",   "waiting"};

TEST(Status, has_the_documented_structure) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    auto fc_link = serial("fc", fc.path());
    fc_link.id = 3;
    anogate::GatewaySettings gateway;
    gateway.id = 199;
    gateway.name = "my gateway";
    RunningGateway daemon{settings_of({fc_link, udp_listen("ground"), serial("gone", dir / "gone"), udp("host", "127.0.0.1:9"),
                                       pty("app", dir / "app"), sim("sim")},
                                      gateway, {{0x40, 0x41, "fc"}})};
    ASSERT_TRUE(daemon.until_up("fc"));
    UdpPeer host;
    host.send(daemon.port("ground"), vendor::who_are_you);
    fc.write(vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until(
        [&] { return !daemon.route("0xFE").is_null() && !daemon.route("0xDB").is_null() && !daemon.route("0xDC").is_null(); }));

    const json status = daemon.status();
    std::set<std::string> keys;
    for (const auto& [key, value] : status.items()) keys.insert(key);
    EXPECT_EQ(keys,
              (std::set<std::string>{"gateway", "links", "routes", "conflicts", "tunnel", "gpio", "http", "map", "recording"}));
    EXPECT_EQ(status.at("gateway").at("id"), 199);
    EXPECT_EQ(status.at("gateway").at("name"), "my gateway");
    EXPECT_TRUE(status.at("gateway").at("version").is_string());
    EXPECT_TRUE(status.at("gateway").at("uptime_s").is_number());
    EXPECT_TRUE(status.at("conflicts").is_array());
    EXPECT_TRUE(status.at("tunnel").is_object());

    ASSERT_EQ(status.at("links").size(), 6u);
    for (const json& link : status.at("links")) {
        EXPECT_TRUE(link.at("name").is_string());
        EXPECT_TRUE(link.at("kind").is_string());
        EXPECT_TRUE(link.at("id").is_number() || link.at("id").is_null());
        EXPECT_TRUE(link.at("state") == "up" || link.at("state") == "waiting");
        EXPECT_TRUE(link.at("since_s").is_number());
        EXPECT_TRUE(link.at("error").is_string());
        EXPECT_TRUE(link.at("hint").is_string());
        EXPECT_EQ(link.at("hint_id") == "", link.at("hint") == "");
        EXPECT_EQ(link.at("error_id") == "", link.at("error") == "");
        EXPECT_TRUE(link.at("error_args").is_object());
        EXPECT_TRUE(link.at("hint_args").is_object());
        EXPECT_TRUE(link.at("channels").is_array());
        for (const char* counter : counters) EXPECT_TRUE(link.at(counter).is_number_unsigned()) << counter;
        for (const json& channel : link.at("channels")) {
            EXPECT_TRUE(channel.at("peer").is_string());
            EXPECT_NE(channel.at("peer"), "") << link.at("name") << ": a person must see what it is";
            for (const char* counter : counters) EXPECT_TRUE(channel.at(counter).is_number_unsigned()) << counter;
        }
        if (link.at("state") == "waiting") {
            EXPECT_NE(link.at("error"), "");
        }
    }
    for (const json& route : status.at("routes")) {
        const std::string address = route.at("address");
        EXPECT_EQ(address.size(), 4u);
        EXPECT_EQ(address.substr(0, 2), "0x");
        EXPECT_TRUE(route.at("who").is_string());
        EXPECT_TRUE(route.at("links").is_array());
        const std::string via = route.at("via");
        EXPECT_TRUE((std::set<std::string>{"own", "port", "pinned", "learned"}.contains(via)));
        EXPECT_EQ(route.contains("age_s"), via == "learned");
    }
    EXPECT_EQ(daemon.route("0x03").at("via"), "port");
    EXPECT_EQ(daemon.route("0x41").at("via"), "pinned");
    EXPECT_EQ(daemon.route("0xDC").at("who"), "flight controller");
}

TEST(Status, has_no_duplicate_keys) {
    RunningGateway daemon{settings_of({udp_listen("ground")})};
    ASSERT_TRUE(daemon.until_up("ground"));
    UdpPeer host;
    host.send(daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return !daemon.link("ground").at("channels").empty(); }));
    std::vector<std::set<std::string>> names;
    const auto look = [&](int, json::parse_event_t event, json& parsed) {
        if (event == json::parse_event_t::object_start) names.emplace_back();
        if (event == json::parse_event_t::key) {
            EXPECT_TRUE(names.back().insert(parsed.get<std::string>()).second) << parsed;
        }
        if (event == json::parse_event_t::object_end) names.pop_back();
        return true;
    };
    EXPECT_FALSE(json::parse(anogate::status_json(daemon.gateway()), look).empty());
}

TEST(Status, survives_names_and_paths_that_are_not_utf_8) {
    RunningGateway daemon{serial("fc", "/nowhere/\xFF\xFE")};
    EXPECT_EQ(daemon.link("fc").at("state"), "waiting");
}

TEST(Status, shows_why_a_link_is_not_up_as_text_and_as_an_error_id) {
    UdpPeer taken;
    const TempDir dir;
    RunningGateway daemon{
        settings_of_texts({"serial:" + (dir / "absent") + ",name=fc", "udp-listen:" + taken.local().text() + ",name=ground",
                           "udp-listen:192.0.2.1:0,name=elsewhere", "pty:" + (dir / "app") + ",name=app"})};
    const auto id_of = [&](const char* link) {
        const auto now = daemon.link(link);
        const std::string id = now.at("error_id");
        const bool is_known = std::any_of(std::begin(anogate::link_error_ids), std::end(anogate::link_error_ids),
                                          [&](const anogate::LinkErrorId& row) { return row.id == id; });
        EXPECT_TRUE(is_known) << id;
        return id + " " + now.at("error_args").dump();
    };
    EXPECT_EQ(id_of("fc"), "absent {\"device\":\"" + (dir / "absent") + "\"}");
    EXPECT_EQ(id_of("ground"), "port_in_use {\"port\":\"" + std::to_string(taken.port()) + "\"}");
    EXPECT_EQ(id_of("elsewhere"), R"(no_address {"address":"192.0.2.1"})");
    EXPECT_EQ(id_of("app"), "nobody_there {\"path\":\"" + (dir / "app") + "\"}");
}

class Hints : public testing::Test {
protected:
    bool has_hint(const std::string& link, const std::string& words) {
        return daemon->until([&] { return daemon->link(link).at("hint").get<std::string>().find(words) != std::string::npos; });
    }
    TempDir dir;
    PtyDevice fc{dir / "fc"};
    std::optional<RunningGateway> daemon;
};

TEST_F(Hints, report_data_without_valid_frames_as_a_wrong_baud_rate) {
    daemon.emplace(settings_of({serial("fc", fc.path())}));
    ASSERT_TRUE(daemon->until_up("fc"));
    fc.write(Bytes(500, 0xF8));
    EXPECT_TRUE(has_hint("fc", "data but no valid frames: check baud rate and protocol"));
    for (int i = 0; i < 30; ++i) fc.write(vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon->until([&] { return daemon->link("fc").at("hint") == ""; })) << "all is well now";
}

TEST_F(Hints, are_logged_once_while_the_link_is_up) {
    daemon.emplace(settings_of({serial("fc", fc.path()), udp_listen("ground")}));
    ASSERT_TRUE(daemon->until_up("fc"));
    anogate::HintLog log;
    EXPECT_TRUE(log.news(daemon->gateway()).empty());
    fc.write(Bytes(500, 0xF8));
    ASSERT_TRUE(has_hint("fc", "data but no valid frames"));
    EXPECT_EQ(log.news(daemon->gateway()),
              std::vector<std::string>{"fc: data but no valid frames: check baud rate and protocol"});
    EXPECT_TRUE(log.news(daemon->gateway()).empty());
    fc.unplug();
    ASSERT_TRUE(daemon->until([&] { return daemon->link("fc").at("state") == "waiting"; }));
    EXPECT_TRUE(log.news(daemon->gateway()).empty());
    fc.plug();
    ASSERT_TRUE(daemon->until_up("fc"));
    EXPECT_EQ(log.news(daemon->gateway()),
              std::vector<std::string>{"fc: data but no valid frames: check baud rate and protocol"});
}

TEST_F(Hints, report_frames_of_an_older_version) {
    daemon.emplace(settings_of({serial("fc", fc.path()), udp_listen("ground")}));
    ASSERT_TRUE(daemon->until_up("fc"));
    Bytes v7 = hex("AA FF 03 07 01 02 03 04 05 06 07");
    const auto checks = ano::checks_of(v7);
    v7 = v7 + Bytes{checks.sum, checks.add};
    fc.write(v7);
    EXPECT_TRUE(has_hint("fc", "older V7 frames (0xAA) received"));
    UdpPeer device;
    device.send(daemon->port("ground"), v7);
    EXPECT_TRUE(has_hint("ground", "older V7 frames (0xAA) received")) << "from a stranger as well";
}

TEST_F(Hints, about_older_frames_end_after_frames_of_the_current_version) {
    daemon.emplace(settings_of({serial("fc", fc.path())}));
    ASSERT_TRUE(daemon->until_up("fc"));
    Bytes v7 = hex("AA FF 03 07 01 02 03 04 05 06 07");
    const auto checks = ano::checks_of(v7);
    fc.write(v7 + Bytes{checks.sum, checks.add});
    ASSERT_TRUE(has_hint("fc", "V7"));
    for (int i = 0; i < 40; ++i) fc.write(vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon->until([&] { return daemon->link("fc").at("hint") == ""; })) << "the device was switched to V8";
}

TEST_F(Hints, report_silence_with_its_length) {
    daemon.emplace(settings_of({serial("fc", fc.path())}));
    ASSERT_TRUE(daemon->until_up("fc"));
    fc.write(vendor::i_am_an_mcu);
    EXPECT_TRUE(has_hint("fc", "silent for 3 s"));
}

TEST_F(Hints, a_changed_baud_rate_is_not_reported_as_silence) {
    daemon.emplace(settings_of({serial("fc", fc.path())}));
    ASSERT_TRUE(daemon->until_up("fc"));
    fc.write(Bytes(500, 0xF8));    // before the frames: an earlier fault, which is ignored
    for (int i = 0; i < 40; ++i) fc.write(vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon->until([&] { return daemon->link("fc").at("frames_in") == 40; }));
    EXPECT_EQ(daemon->link("fc").at("hint"), "");
    EXPECT_TRUE(daemon->until([&] {
        fc.write(Bytes(20, 0xF8));
        const std::string hint = daemon->link("fc").at("hint");
        return hint.starts_with("data but no valid frames for ") && hint.ends_with(" s: check baud rate and firmware");
    })) << daemon->link("fc").at("hint");
    fc.write(vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon->until([&] { return daemon->link("fc").at("hint") == ""; }));
    EXPECT_TRUE(has_hint("fc", "silent for 3 s")) << "and nothing more comes";
}

TEST_F(Hints, report_a_device_that_never_sent_and_a_port_without_a_peer) {
    daemon.emplace(settings_of({serial("fc", fc.path()), udp_listen("ground")}));
    EXPECT_TRUE(has_hint("fc",
                         "nothing received yet: check that the device is powered and that RX and TX are crossed (some devices "
                         "send only after they receive a frame: try hello=on)"));
    EXPECT_TRUE(has_hint("ground", "waiting for a peer"));
}

TEST_F(Hints, report_a_slow_link) {
    auto link = serial("fc", fc.path());
    link.queue = 5000;
    daemon.emplace(settings_of({link, udp_listen("air")}));
    ASSERT_TRUE(daemon->until_up("fc"));
    UdpPeer air;
    EXPECT_TRUE(daemon->until([&] {
        air.send(daemon->port("air"), frame(0xDC, 0xFE, 0xF1, Bytes(1000)));
        return daemon->link("fc").at("hint").get<std::string>().find("more is sent to this link") != std::string::npos;
    }));
}

}    // namespace
}    // namespace status_tests
