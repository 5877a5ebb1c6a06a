// The paths of frames over real links: the Router's rules as users see them.
#include <link/udp/udp_settings.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <algorithm>

namespace routing_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

// Three devices on serial links a, b, c; each test sets the keys of its links.
class Routing : public testing::Test {
protected:
    void start(anogate::GatewaySettings gateway = {}, std::vector<anogate::RouteSettings> routes = {}) {
        daemon.emplace(settings_of({a_link, b_link, c_link}, gateway, std::move(routes)));
        ASSERT_TRUE(daemon->until_up("a") && daemon->until_up("b") && daemon->until_up("c"));
    }
    /// `from` sends the frame; true: it was routed.
    bool send(PtyDevice& from, const std::string& link, const Bytes& bytes) {
        const auto before = daemon->count(link, "bytes_in");
        from.write(bytes);
        return daemon->until([&] { return daemon->count(link, "bytes_in") == before + bytes.size(); });
    }
    /// The frames received by each since the last call, after everything was sent.
    struct Heard {
        Bytes a, b, c;
    };
    Heard heard() {
        Heard result;
        daemon->run_for(10ms);
        daemon->until([&] {
            result.a = result.a + a.read();
            result.b = result.b + b.read();
            result.c = result.c + c.read();
            return daemon->count("a", "waiting") + daemon->count("b", "waiting") + daemon->count("c", "waiting") == 0;
        });
        return result;
    }

    TempDir dir;
    PtyDevice a{dir / "a"}, b{dir / "b"}, c{dir / "c"};
    anogate::LinkSettings a_link = serial("a", a.path()), b_link = serial("b", b.path()), c_link = serial("c", c.path());
    std::optional<RunningGateway> daemon;
};

TEST_F(Routing, frames_for_a_learned_address_are_sent_only_to_its_link) {
    start();
    ASSERT_TRUE(send(b, "b", frame(30, 0xFE, 0x01)));
    heard();
    ASSERT_TRUE(send(a, "a", frame(0xFE, 30, 0xE0, {0, 0, 0})));
    const Heard now = heard();
    EXPECT_EQ(now.b, frame(0xFE, 30, 0xE0, {0, 0, 0}));
    EXPECT_TRUE(now.a.empty() && now.c.empty());
    EXPECT_EQ(daemon->route("0x1E").at("via"), "learned");
    EXPECT_EQ(daemon->route("0x1E").at("links"), nlohmann::json{"b"});
    EXPECT_EQ(daemon->route("0x1E").at("who"), "user device");
}

TEST_F(Routing, frames_for_a_port_id_are_sent_to_the_link_with_that_id) {
    b_link.id = 5;
    start();
    ASSERT_TRUE(send(a, "a", frame(0xFE, 5, 0xE0, {0, 0, 0})));
    const Heard now = heard();
    EXPECT_EQ(now.b, frame(0xFE, 5, 0xE0, {0, 0, 0}));
    EXPECT_TRUE(now.c.empty());
    EXPECT_EQ(daemon->route("0x05").at("via"), "port");
    EXPECT_EQ(daemon->link("b").at("id"), 5);
    EXPECT_TRUE(daemon->link("a").at("id").is_null());
}

TEST_F(Routing, frames_for_a_pinned_range_are_sent_to_its_link_whatever_was_learned) {
    start({}, {{30, 40, "c"}});
    ASSERT_TRUE(send(b, "b", frame(35, 0xFE, 0x01)));
    heard();
    ASSERT_TRUE(send(a, "a", frame(0xFE, 35, 0xC0, {1})));
    const Heard now = heard();
    EXPECT_EQ(now.c, frame(0xFE, 35, 0xC0, {1}));
    EXPECT_TRUE(now.b.empty());
    EXPECT_EQ(daemon->route("0x23").at("via"), "pinned");
    EXPECT_EQ(daemon->route("0x28").at("links"), nlohmann::json{"c"});
    EXPECT_TRUE(daemon->route("0x29").is_null());
}

TEST_F(Routing, a_broadcast_is_sent_to_every_other_link_that_accepts_broadcasts) {
    c_link.broadcast = false;
    start();
    ASSERT_TRUE(send(a, "a", vendor::who_are_you));
    const Heard now = heard();
    EXPECT_EQ(now.b, vendor::who_are_you);
    EXPECT_TRUE(now.a.empty()) << "never back";
    EXPECT_TRUE(now.c.empty()) << "broadcast=no";
}

TEST_F(Routing, frames_for_an_unknown_address_are_flooded_except_to_links_with_flood_no) {
    c_link.flood = false;
    start();
    ASSERT_TRUE(send(a, "a", frame(0xFE, 77, 0xC0, {1})));
    const Heard now = heard();
    EXPECT_EQ(now.b, frame(0xFE, 77, 0xC0, {1}));
    EXPECT_TRUE(now.c.empty());
}

TEST_F(Routing, unknown_drop_drops_and_counts_frames_without_a_route) {
    anogate::GatewaySettings gateway;
    gateway.unknown = anogate::Unknown::drop;
    start(gateway);
    ASSERT_TRUE(send(a, "a", frame(0xFE, 77, 0xC0, {1})));
    const Heard now = heard();
    EXPECT_TRUE(now.b.empty() && now.c.empty());
    EXPECT_EQ(daemon->count("a", "no_route"), 1u);
}

TEST_F(Routing, unknown_link_sends_frames_for_unknown_addresses_to_one_link) {
    anogate::GatewaySettings gateway;
    gateway.unknown = anogate::Unknown::link;
    gateway.unknown_link = "c";
    start(gateway);
    ASSERT_TRUE(send(a, "a", frame(0xFE, 77, 0xC0, {1})));
    const Heard now = heard();
    EXPECT_EQ(now.c, frame(0xFE, 77, 0xC0, {1}));
    EXPECT_TRUE(now.b.empty());
}

TEST_F(Routing, frames_for_the_gateway_itself_are_not_forwarded) {
    anogate::GatewaySettings gateway;
    gateway.id = 199;
    start(gateway);
    ASSERT_TRUE(send(a, "a", frame(0xFE, 199, 0xC0, {1})));
    const Heard now = heard();
    EXPECT_TRUE(now.b.empty() && now.c.empty());
    EXPECT_EQ(daemon->count("a", "no_route"), 0u);
    EXPECT_EQ(daemon->status().at("gateway").at("own_frames"), 1);
    EXPECT_EQ(daemon->route("0xC7").at("via"), "own");
}

TEST_F(Routing, frames_for_destination_0_are_dropped) {
    start();
    ASSERT_TRUE(send(a, "a", frame(0xFE, 0, 0xC0, {1})));
    const Heard now = heard();
    EXPECT_TRUE(now.b.empty() && now.c.empty());
    EXPECT_EQ(daemon->count("a", "no_route"), 1u);
}

TEST_F(Routing, two_hosts_both_0xFE_both_get_the_answer) {
    start();
    ASSERT_TRUE(send(a, "a", vendor::who_are_you) && send(b, "b", vendor::who_are_you));
    heard();
    ASSERT_TRUE(send(c, "c", vendor::i_am_an_mcu));
    const Heard now = heard();
    EXPECT_EQ(now.a, vendor::i_am_an_mcu);
    EXPECT_EQ(now.b, vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon->status().at("conflicts").empty()) << "hosts may share an id";
}

TEST_F(Routing, two_devices_with_one_id_are_shown_as_a_conflict) {
    start();
    ASSERT_TRUE(send(a, "a", frame(0xDE, 0xFE, 0x51, {0, 0, 0, 0, 0})) && send(b, "b", frame(0xDE, 0xFE, 0x51, {0, 0, 0, 0, 1})));
    EXPECT_TRUE(daemon->status().at("conflicts").empty()) << "it may have moved";
    ASSERT_TRUE(send(a, "a", frame(0xDE, 0xFE, 0x51, {0, 0, 0, 0, 2})));
    ASSERT_TRUE(daemon->until([&] { return !daemon->status().at("conflicts").empty(); }));
    const auto conflict = daemon->status().at("conflicts").at(0);
    EXPECT_EQ(conflict.at("address"), "0xDE");
    EXPECT_EQ(conflict.at("links"), (nlohmann::json{"a", "b"}));
    EXPECT_EQ(conflict.at("claimed_by").at("link"), "b");
    const Bytes command = frame(0xFE, 0xDE, 0xC0, {1});
    ASSERT_TRUE(send(c, "c", command));
    const Heard now = heard();
    EXPECT_NE(std::search(now.a.begin(), now.a.end(), command.begin(), command.end()), now.a.end());
    EXPECT_EQ(std::search(now.b.begin(), now.b.end(), command.begin(), command.end()), now.b.end()) << "it was there second";
}

TEST_F(Routing, the_hint_for_two_devices_with_one_id_differs_from_that_for_one_device) {
    start();
    ASSERT_TRUE(send(c, "c", vendor::who_are_you));
    int n = 0;
    ASSERT_TRUE(daemon->until([&] {
        ++n;
        a.write(frame(0xDE, 0xFE, 0x51, {0, 0, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8), 0}));
        b.write(frame(0xDE, 0xFE, 0x51, {0, 0, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8), 1}));
        daemon->run_for(5ms);
        return daemon->link("a").at("hint") ==
               "different frames with one id arrive on two links: if these are two devices, change the id of one (0xDE)";
    }));
    EXPECT_EQ(daemon->link("b").at("hint"),
              "different frames with one id arrive on two links: if these are two devices, change the id of one (0xDE)");
    EXPECT_EQ(daemon->link("c").at("hint"), "");
}

// Its frames reach the host once; a broadcast command reaches it over both cables, and a hint must report it.
TEST_F(Routing, the_hint_for_one_device_on_two_cables_suggests_a_group) {
    start();
    ASSERT_TRUE(send(c, "c", vendor::who_are_you));
    for (std::uint8_t n = 0; n < 3; ++n) {
        ASSERT_TRUE(send(a, "a", frame(0xDC, 0xFE, 0x03, {n})) && send(b, "b", frame(0xDC, 0xFE, 0x03, {n})));
    }
    EXPECT_EQ(daemon->link("a").at("hint"),
              "the same frames arrive on two links: if it is one device, put both links in one `group`; if two, change the id of "
              "one (0xDC)");
    EXPECT_EQ(daemon->link("b").at("hint"),
              "the same frames arrive on two links: if it is one device, put both links in one `group`; if two, change the id of "
              "one (0xDC)");
    EXPECT_EQ(daemon->link("c").at("hint"), "");
    const auto conflict = daemon->status().at("conflicts").at(0);
    EXPECT_EQ(conflict.at("address"), "0xDC");
    EXPECT_EQ(conflict.at("links"), (nlohmann::json{"a", "b"}));
}

TEST_F(Routing, a_device_on_the_two_cables_of_a_group_is_no_conflict) {
    a_link.group = b_link.group = "fc";
    start();
    ASSERT_TRUE(send(c, "c", vendor::who_are_you));
    for (std::uint8_t n = 0; n < 3; ++n) {
        ASSERT_TRUE(send(a, "a", frame(0xDC, 0xFE, 0x03, {n})) && send(b, "b", frame(0xDC, 0xFE, 0x03, {n})));
    }
    EXPECT_EQ(daemon->link("a").at("hint"), "");
    EXPECT_TRUE(daemon->status().at("conflicts").empty());
}

TEST_F(Routing, a_device_whose_address_is_the_port_id_of_another_link_is_reported) {
    b_link.id = 5;
    c_link.id = 6;
    start();
    ASSERT_TRUE(send(a, "a", frame(5, 0xFE, 0x01)) && send(c, "c", frame(6, 0xFE, 0x01)));
    EXPECT_EQ(daemon->link("a").at("hint"),
              "device 0x05 can't be reached: its address is also the port id of a link; change one of them");
    EXPECT_EQ(daemon->link("b").at("hint"), "");
    EXPECT_EQ(daemon->link("c").at("hint"), "") << "it is behind its port";
}

TEST_F(Routing, present_as_replaces_host_addresses_with_the_one_that_a_device_answers) {
    c_link.present_as = 0xFE;
    start();
    const Bytes command = frame(0xD2, 0xDC, 0xC0, {1, 2, 3}), presented = frame(0xFE, 0xDC, 0xC0, {1, 2, 3});
    ASSERT_TRUE(send(a, "a", command) && send(b, "b", frame(0xFE, 0xDC, 0xC0, {1, 2, 3})));
    EXPECT_EQ(heard().c, presented + presented);
    const auto acknowledged = [](const Bytes& sent) {
        const std::size_t n = sent.size();
        return frame(0xDC, sent[1], 0x00, {0xC0, sent[n - 2], sent[n - 1]});
    };
    ASSERT_TRUE(send(c, "c", acknowledged(presented)));
    Heard now = heard();
    EXPECT_EQ(now.a, acknowledged(command));
    EXPECT_TRUE(now.b.empty());
    ASSERT_TRUE(send(c, "c", acknowledged(presented)));
    now = heard();
    EXPECT_EQ(now.b, acknowledged(presented));
    EXPECT_TRUE(now.a.empty());

    ASSERT_TRUE(send(a, "a", frame(0xD2, 0xDC, 0xE0, {2, 7, 0})));
    EXPECT_EQ(heard().c, frame(0xFE, 0xDC, 0xE0, {2, 7, 0}));
    ASSERT_TRUE(
        send(c, "c", frame(0xDC, 0xFE, 0xE1, {8, 0, 1}) + frame(0xDC, 0xFE, 0xE1, {7, 0, 1}) + frame(0xDC, 0xFE, 0x03, {1})));
    now = heard();
    EXPECT_EQ(now.a, frame(0xDC, 0xD2, 0xE1, {7, 0, 1}));
    EXPECT_EQ(now.b, frame(0xDC, 0xFE, 0xE1, {8, 0, 1}) + frame(0xDC, 0xFE, 0x03, {1}));
}

TEST_F(Routing, present_as_works_together_with_an_alias) {
    c_link.present_as = 0xFE;
    anogate::Settings settings = settings_of({a_link, b_link, c_link});
    settings.aliases = {{"c", 0xDE, 31}};
    daemon.emplace(settings);
    ASSERT_TRUE(daemon->until_up("a") && daemon->until_up("c"));
    const Bytes sent = frame(0xD2, 31, 0xE1, {3, 0, 42}), reached = frame(0xFE, 0xDE, 0xE1, {3, 0, 42});
    ASSERT_TRUE(send(a, "a", sent));
    EXPECT_EQ(heard().c, reached);
    const std::size_t n = sent.size();
    ASSERT_TRUE(send(c, "c", frame(0xDE, 0xFE, 0x00, {0xE1, reached[n - 2], reached[n - 1]})));
    EXPECT_EQ(heard().a, frame(31, 0xD2, 0x00, {0xE1, sent[n - 2], sent[n - 1]}));
}

// The question may be sent on one link and its answer be received on both.
TEST_F(Routing, present_as_applies_to_all_links_of_a_group) {
    b_link.present_as = c_link.present_as = 0xFE;
    b_link.group = c_link.group = "fc";
    start();
    ASSERT_TRUE(send(b, "b", frame(0xDC, 0xFE, 0x03, {1})));
    heard();
    for (const std::uint8_t from : Bytes{0xD2, 100}) {
        ASSERT_TRUE(send(a, "a", frame(from, 0xDC, 0xE0, {2, 7, 0})));
        EXPECT_EQ(heard().b, frame(0xFE, 0xDC, 0xE0, {2, 7, 0}));
    }
    for (const std::uint8_t asker : Bytes{0xD2, 100}) {
        const Bytes answer = frame(0xDC, 0xFE, 0xE1, {7, 0, 9});
        ASSERT_TRUE(send(c, "c", answer) && send(b, "b", answer));
        EXPECT_EQ(heard().a, frame(0xDC, asker, 0xE1, {7, 0, 9}));
    }
}

TEST_F(Routing, frames_of_one_link_keep_their_order) {
    start();
    ASSERT_TRUE(send(b, "b", frame(0xFE, 0xDC, 0xE0, {0, 0, 0})));
    heard();
    Bytes sent;
    for (std::uint8_t n = 0; n < 200; ++n) sent = sent + frame(0xDC, 0xFE, 0xA0, Bytes(1 + n % 14, n));
    for (std::size_t done = 0; done < sent.size();) {
        done += a.write(std::span{sent}.subspan(done, std::min<std::size_t>(sent.size() - done, 333)));
        daemon->run_for(1ms);
    }
    EXPECT_TRUE(daemon->until([&] { return b.heard() == sent; }));
}

TEST_F(Routing, a_frame_larger_than_a_link_carries_is_counted_there) {
    a_link.max_data = 1000;
    b_link.max_data = 100;
    start();
    ASSERT_TRUE(send(a, "a", frame(0xDC, 0xFF, 0xB0, Bytes(101))) && send(a, "a", frame(0xDC, 0xFF, 0xB0, Bytes(100))));
    const Heard now = heard();
    EXPECT_EQ(split(now.b).frames.size(), 1u);
    EXPECT_EQ(split(now.c).frames.size(), 2u);
    EXPECT_EQ(daemon->count("b", "too_big"), 1u);
}

TEST_F(Routing, frames_without_data_pass_and_are_counted) {
    start();
    ASSERT_TRUE(send(a, "a", frame(0xDC, 0xFF, 0xF1)));
    EXPECT_EQ(heard().b, frame(0xDC, 0xFF, 0xF1));
    EXPECT_EQ(daemon->count("b", "empty_out"), 1u);
}

TEST(Gateway, telemetry_without_a_registered_host_is_reported_until_a_host_sends) {
    TempDir dir;
    PtyDevice device{dir / "fc"};
    RunningGateway daemon{serial("fc", device.path()), udp_listen("ground")};
    ASSERT_TRUE(daemon.until_up("fc"));
    const auto hint_is = [&](const std::string& words) {
        return daemon.until([&] {
            device.write(frame(0xDC, 0xFE, 0x03, {1}));
            daemon.run_for(20ms);
            return daemon.link("fc").at("hint") == words;
        });
    };
    EXPECT_TRUE(
        hint_is("no ground station is registered for this telemetry yet (anoctl and the page see it anyway); have it send a "
                "frame, or add --route 0xFE=LINK"));
    UdpPeer host;
    host.send(daemon.port("ground"), vendor::who_are_you);
    EXPECT_TRUE(hint_is(""));
}

TEST(Gateway, telemetry_for_a_host_whose_cable_is_pulled_is_sent_to_other_links) {
    TempDir dir;
    PtyDevice device{dir / "fc"};
    PtyDevice radio{dir / "radio"};
    UdpPeer listener;
    RunningGateway daemon{serial("fc", device.path()), serial("radio", radio.path()), udp("tablet", listener.local().text())};
    ASSERT_TRUE(daemon.until_up("fc") && daemon.until_up("radio") && daemon.until_up("tablet"));
    radio.write(frame(0xFE, 0x01, 0x03, {1}));
    ASSERT_TRUE(daemon.until([&] { return daemon.count("radio", "frames_in") == 1; }));
    listener.forget();
    const Bytes telemetry = frame(0xDC, 0xFE, 0x03, {1});
    device.write(telemetry);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("radio", "frames_out") > 0; }));
    EXPECT_EQ(listener.heard(), Bytes{}) << "the host is by the radio";
    radio.unplug();
    ASSERT_TRUE(daemon.until([&] { return daemon.link("radio").at("state") == "waiting"; }));
    device.write(telemetry);
    EXPECT_TRUE(daemon.until([&] { return listener.heard() == telemetry; }));
}

TEST(Gateway, telemetry_for_a_host_whose_cable_is_pulled_is_reported_if_no_other_link_can_send_it) {
    TempDir dir;
    PtyDevice device{dir / "fc"};
    PtyDevice radio{dir / "radio"};
    RunningGateway daemon{serial("fc", device.path()), serial("radio", radio.path())};
    ASSERT_TRUE(daemon.until_up("fc") && daemon.until_up("radio"));
    radio.write(frame(0xFE, 0xDC, 0x03, {1}));
    ASSERT_TRUE(daemon.until([&] { return daemon.count("radio", "frames_in") == 1; }));
    radio.unplug();
    EXPECT_TRUE(daemon.until([&] {
        device.write(frame(0xDC, 0xFE, 0x03, {1}));
        daemon.run_for(20ms);
        return daemon.link("fc").at("hint_id") == "hosts_link_down";
    })) << daemon.link("fc");
    EXPECT_EQ(daemon.link("fc").at("hint_args").at("link"), "radio");
}

// Each link has one hint. It names its address if the hint of the other link is about a different address.
TEST(Gateway, hints_of_two_conflicts_name_the_address_and_those_of_one_are_the_same) {
    TempDir dir;
    PtyDevice a{dir / "a"}, b{dir / "b"}, c{dir / "c"};
    UdpPeer host;
    RunningGateway daemon{serial("a", a.path()), serial("b", b.path()), serial("c", c.path()), udp_listen("ground")};
    ASSERT_TRUE(daemon.until_up("a") && daemon.until_up("b") && daemon.until_up("c"));
    host.send(daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("a", "frames_out") == 1; }));
    int n = 0;
    const auto telemetry = [&](std::uint8_t from, std::uint8_t last) {
        return frame(from, 0xFE, 0x51, {0, 0, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8), last});
    };
    const auto hint = [&](const char* link) { return std::string{daemon.link(link).at("hint")}; };
    EXPECT_TRUE(daemon.until([&] {
        ++n;
        a.write(telemetry(0xDE, 0));
        b.write(telemetry(0xDE, 1));
        b.write(telemetry(0xDD, 0));
        c.write(telemetry(0xDD, 0));
        daemon.run_for(5ms);
        return hint("a").starts_with("different frames") && hint("b").find("0xDD") != std::string::npos;
    })) << hint("a")
        << " / " << hint("b");
    EXPECT_EQ(hint("a"),
              "different frames with one id arrive on two links: if these are two devices, change the id of one (0xDE)");
    EXPECT_EQ(hint("b"), hint("c"));
    EXPECT_TRUE(hint("b").starts_with("the same frames arrive on two links: if it is one device")) << hint("b");
}

// While no host is known, frames from one cable are sent to the other, which looks the same as a ring.
TEST(Gateway, a_device_on_two_cables_is_reported_before_a_host_sends) {
    TempDir dir;
    PtyDevice one{dir / "one"}, two{dir / "two"};
    RunningGateway daemon{serial("one", one.path()), serial("two", two.path()), udp_listen("ground")};
    ASSERT_TRUE(daemon.until_up("one") && daemon.until_up("two"));
    const std::string words =
        "the same frames arrive on two links: if it is one device, put both links in one `group`; if two, change the id of one";
    std::uint8_t count = 0;
    EXPECT_TRUE(daemon.until([&] {
        one.write(frame(0xDC, 0xFE, 0x03, {count}));
        two.write(frame(0xDC, 0xFE, 0x03, {count++}));
        daemon.run_for(20ms);
        const std::string by_one = daemon.link("one").at("hint"), by_two = daemon.link("two").at("hint");
        return by_one.starts_with(words) && by_two.starts_with(words);
    })) << daemon.link("one").at("hint")
        << " / " << daemon.link("two").at("hint");
    for (int i = 0; i < 100; ++i) {    // this state lasts
        one.write(frame(0xDC, 0xFE, 0x03, {count}));
        two.write(frame(0xDC, 0xFE, 0x03, {count++}));
        daemon.run_for(20ms);
        EXPECT_TRUE(std::string{daemon.link("one").at("hint")}.starts_with(words)) << daemon.link("one").at("hint");
        EXPECT_TRUE(std::string{daemon.link("two").at("hint")}.starts_with(words)) << daemon.link("two").at("hint");
    }
}

TEST(Gateway, a_link_has_at_most_sixty_four_channels) {
    auto ground = udp_listen("ground");
    ground.as<anogate::UdpListenSettings>().max_peers = 100;
    RunningGateway daemon{ground};
    std::vector<std::unique_ptr<UdpPeer>> hosts;
    for (int i = 0; i < 70; ++i) {
        hosts.push_back(std::make_unique<UdpPeer>());
        hosts.back()->send(daemon.port("ground"), vendor::who_are_you);
    }
    EXPECT_TRUE(daemon.until([&] { return daemon.count("ground", "denied_in") == 6; }));
    EXPECT_EQ(daemon.link("ground").at("channels").size(), 64u);
    hosts[0]->forget();
    hosts[1]->send(daemon.port("ground"), vendor::write_parameter);
    EXPECT_TRUE(daemon.until([&] { return hosts[0]->heard() == vendor::write_parameter; })) << "those who are in are served";
}

}    // namespace
}    // namespace routing_tests
