// Links that send a hello first, and devices that accept few questions at a time, on real ptys and sockets.
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <algorithm>

namespace hello_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::Clock;
using anogate::LinkSettings;
using anogate::TimePoint;

const Bytes hello = hex("AB FE FF E0 03 00 00 00 00 8B 3B");
const Bytes euler = frame(0xDC, 0xFE, 0x03, Bytes(7));
const Bytes who_i_am = frame(0xDC, 0xFE, 0xE3, Bytes(9, 0xDC));

LinkSettings speaking(LinkSettings link, anogate::Duration interval = 2s) {
    link.hello = interval;
    return link;
}
// Without the hello of the profile, whose frames would mix with the others.
LinkSettings of_vendor(LinkSettings link) {
    link.profile = anogate::Profile::vendor;
    link.hello = 0s;
    return link;
}

struct Hello : testing::Test {
    std::size_t hellos() {
        const auto frames = split(fc.heard()).frames;
        return static_cast<std::size_t>(std::count(frames.begin(), frames.end(), hello));
    }
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
};

TEST_F(Hello, is_sent_after_a_second_of_silence_and_again_and_counted) {
    RunningGateway gateway{speaking(serial("fc", fc.path()), 1s), udp_listen("ground")};
    ASSERT_TRUE(gateway.until_up("fc"));
    const TimePoint up = Clock::now();
    ASSERT_TRUE(gateway.until([&] { return hellos() == 1; }));
    EXPECT_GE(Clock::now() - up, 990ms);
    ASSERT_TRUE(gateway.until([&] { return hellos() == 2; }));
    EXPECT_GE(Clock::now() - up, 1990ms);
    EXPECT_EQ(fc.heard(), hello + hello);
    EXPECT_EQ(gateway.count("fc", "frames_out"), 2u);
    EXPECT_EQ(gateway.count("ground", "frames_out"), 0u);
    EXPECT_TRUE(gateway.route("0xFE").is_null()) << "no host was heard";
    EXPECT_TRUE(gateway.counters_add_up());
}

TEST_F(Hello, is_not_sent_while_frames_are_received) {
    RunningGateway gateway{speaking(serial("fc", fc.path()), 1s)};
    ASSERT_TRUE(gateway.until_up("fc"));
    for (int i = 0; i < 15; ++i) {
        fc.write(euler);
        gateway.run_for(100ms);
    }
    EXPECT_EQ(hellos(), 0u);
    EXPECT_TRUE(gateway.until([&] { return hellos() == 1; })) << "and then it falls silent";
}

TEST_F(Hello, is_not_sent_after_a_firmware_frame_on_the_link_or_where_broadcasts_are_off) {
    PtyDevice radio{dir / "radio"};
    PtyDevice gps{dir / "gps"};
    LinkSettings apart = speaking(serial("gps", gps.path()));
    apart.broadcast = apart.flood = false;
    RunningGateway gateway{speaking(serial("fc", fc.path())), speaking(serial("radio", radio.path())), apart};
    ASSERT_TRUE(gateway.until_up("fc") && gateway.until_up("radio") && gateway.until_up("gps"));
    fc.write(frame(0xDC, 0x32, 0xF0, {0, 0x10, 0x10}));    // to an unknown address: forwarded to the radio
    ASSERT_TRUE(gateway.until([&] { return !radio.heard().empty(); }));
    gateway.run_for(1300ms);
    EXPECT_EQ(hellos(), 0u);
    EXPECT_EQ(split(radio.heard()).frames.size(), 1u);
    EXPECT_EQ(gps.heard(), Bytes{});
}

TEST_F(Hello, follows_the_rules_of_its_link) {
    LinkSettings link = speaking(serial("fc", fc.path()));
    link.rules.send.deny_sources = {{0xFE, 0xFE}};
    RunningGateway gateway{link};
    ASSERT_TRUE(gateway.until([&] { return gateway.count("fc", "denied_out") == 1; }));
    EXPECT_EQ(fc.heard(), Bytes{});
}

// No probe is sent on serial ports, and another host may send the same question, so the loop is recognised by 200 copies in a
// second.
TEST_F(Hello, is_stopped_when_it_loops_between_two_links_joined_elsewhere) {
    PtyDevice back{dir / "back"};
    RunningGateway gateway{speaking(serial("fc", fc.path()), 1s), serial("back", back.path())};
    ASSERT_TRUE(gateway.until_up("fc") && gateway.until_up("back"));
    std::size_t rounds = 0;
    const TimePoint end = Clock::now() + 1800ms;
    gateway.until([&] {
        for (const Bytes& frame : split(fc.read()).frames) {
            if (frame == hello) ++rounds;
            back.write(frame);
        }
        for (const Bytes& frame : split(back.read()).frames) fc.write(frame);
        return Clock::now() >= end;
    });
    EXPECT_GE(rounds, 1u);
    EXPECT_LE(rounds, 410u);
}

TEST_F(Hello, wakes_a_bridge_that_waits_for_a_datagram) {
    UdpPeer bridge;
    UdpPeer station;
    RunningGateway gateway{speaking(udp("bridge", "127.0.0.1:" + std::to_string(bridge.port()))), udp_listen("ground")};
    ASSERT_TRUE(gateway.until_up("bridge") && gateway.until_up("ground"));
    station.send(gateway.port("ground"), frame(0xFE, 0x32, 0xA0, {0}));    // registers a host
    ASSERT_TRUE(gateway.until([&] {
        const auto got = bridge.datagrams();
        return std::find(got.begin(), got.end(), hello) != got.end();
    }));
    bridge.send(gateway.port("bridge"), who_i_am);
    EXPECT_TRUE(gateway.until([&] { return station.heard() == who_i_am; })) << "its answer goes to the hosts";
}

TEST_F(Hello, does_not_delay_the_stop_of_the_gateway) {
    LinkSettings link = serial("fc", fc.path());
    link.profile = anogate::Profile::vendor;
    RunningGateway gateway{link};
    ASSERT_TRUE(gateway.until([&] { return hellos() == 1; })) << "without being told to";
    EXPECT_LT(gateway.stop(), 400ms) << "no alarm keeps the loop";
}

class VendorDevice : public testing::Test {
protected:
    void start(LinkSettings link) {
        gateway.emplace(settings_of({std::move(link), udp_listen("ground")}));
        ASSERT_TRUE(gateway->until_up("fc"));
        fc.write(euler);    // it is known, and not silent
        station.send(gateway->port("ground"), frame(0xFE, 0xDC, 0xA0, {0}));
        ASSERT_TRUE(gateway->until([&] { return heard().size() == 1; }));
    }
    void send(const Bytes& bytes) {
        station.send(gateway->port("ground"), bytes);
        ++sent;
        ASSERT_TRUE(gateway->until([&] { return gateway->count("ground", "frames_in") == sent; }));
    }
    Bytes ask(std::uint8_t n) { return frame(0xFE, 0xDC, 0xE0, {3, n, 0}); }
    Bytes answer(std::uint8_t n) { return frame(0xDC, 0xFE, 0xE2, Bytes{n, 0, 8, 'P'}); }
    std::vector<Bytes> heard() { return split(fc.heard()).frames; }
    bool until_heard(std::size_t frames) {
        return gateway->until([&] { return heard().size() >= frames; });
    }

    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    UdpPeer station;
    std::optional<RunningGateway> gateway;
    std::uint64_t sent = 1;
};

TEST_F(VendorDevice, the_eighth_request_waits_until_one_is_answered_and_commands_pass_it) {
    start(of_vendor(serial("fc", fc.path())));
    for (std::uint8_t n = 0; n < 10; ++n) send(ask(n));
    const Bytes lock = frame(0xFE, 0xDC, 0xC0, {0x10, 0, 2});
    send(lock);
    ASSERT_TRUE(until_heard(9));
    EXPECT_EQ(heard()[8], lock);
    EXPECT_EQ(heard()[7], ask(6)) << "the eighth place is kept for the gateway's own questions";
    EXPECT_EQ(gateway->count("fc", "waiting"), 3u);
    EXPECT_TRUE(gateway->counters_add_up());
    const TimePoint answered = Clock::now();
    fc.write(answer(4));
    ASSERT_TRUE(until_heard(10));
    EXPECT_LT(Clock::now() - answered, 450ms) << "by the answer, not by the time";
    EXPECT_EQ(heard()[9], ask(7));
    EXPECT_EQ(gateway->count("fc", "waiting"), 2u);
}

TEST_F(VendorDevice, the_eighth_request_is_sent_when_the_others_stay_unanswered) {
    start(of_vendor(serial("fc", fc.path())));
    const TimePoint asked = Clock::now();
    for (std::uint8_t n = 0; n < 20; ++n) send(ask(n));
    ASSERT_TRUE(until_heard(1 + 16));
    EXPECT_GE(Clock::now() - asked, 500ms);
    ASSERT_TRUE(until_heard(1 + 20));
    EXPECT_GE(Clock::now() - asked, 1000ms);
    EXPECT_EQ(gateway->count("fc", "frames_out"), 21u);
    EXPECT_TRUE(gateway->counters_add_up());
}

TEST_F(VendorDevice, waiting_requests_are_counted_when_the_device_is_unplugged) {
    start(of_vendor(serial("fc", fc.path())));
    for (std::uint8_t n = 0; n < 12; ++n) send(ask(n));
    EXPECT_EQ(gateway->count("fc", "waiting"), 5u);
    fc.unplug();
    ASSERT_TRUE(gateway->until_waiting("fc"));
    EXPECT_EQ(gateway->count("fc", "link_down"), 5u);
    EXPECT_EQ(gateway->count("fc", "waiting"), 0u);
    EXPECT_TRUE(gateway->counters_add_up());
    fc.plug();
    ASSERT_TRUE(gateway->until_up("fc"));
    const std::uint64_t before = gateway->count("fc", "frames_out");
    for (std::uint8_t n = 0; n < 7; ++n) send(ask(n));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("fc", "frames_out") == before + 7; })) << "nothing old is in flight";
}

TEST_F(VendorDevice, the_shutdown_does_not_wait_for_answers) {
    start(of_vendor(serial("fc", fc.path())));
    for (std::uint8_t n = 0; n < 12; ++n) send(ask(n));
    EXPECT_LT(gateway->stop(), 400ms);
    EXPECT_EQ(gateway->count("fc", "link_down"), 5u);
    EXPECT_TRUE(gateway->counters_add_up());
}

TEST_F(VendorDevice, receives_at_most_198_bytes_of_data_and_never_an_empty_frame) {
    start(of_vendor(serial("fc", fc.path())));
    send(frame(0xFE, 0xDC, 0xFB, Bytes(199)));
    send(frame(0xFE, 0xDC, 0xFB));
    send(frame(0xFE, 0xDC, 0xFB, Bytes(198)));
    ASSERT_TRUE(until_heard(2));
    EXPECT_EQ(heard().back(), frame(0xFE, 0xDC, 0xFB, Bytes(198)));
    EXPECT_EQ(gateway->count("fc", "too_big"), 1u);
    EXPECT_EQ(gateway->count("fc", "denied_out"), 1u);
    EXPECT_EQ(gateway->count("fc", "empty_out"), 0u);
    const Bytes image = frame(0xDC, 0xFE, 0xB0, Bytes(4000));
    fc.write(image);
    EXPECT_TRUE(gateway->until([&] { return gateway->count("ground", "bytes_out") >= image.size(); }))
        << "what it sends may be larger";
}

TEST_F(VendorDevice, has_separate_limits_for_received_and_sent_frames) {
    LinkSettings link = serial("fc", fc.path());
    link.max_data = 50;
    link.max_data_out = 100;
    start(link);
    send(frame(0xFE, 0xDC, 0xFB, Bytes(100)));
    send(frame(0xFE, 0xDC, 0xFB, Bytes(101)));
    ASSERT_TRUE(until_heard(2));
    EXPECT_EQ(gateway->count("fc", "too_big"), 1u);
    fc.write(frame(0xDC, 0xFE, 0xFB, Bytes(51)));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("fc", "bad_length") == 1; }));
}

}    // namespace
}    // namespace hello_tests
