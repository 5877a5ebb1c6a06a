// The effect of keys on the frames of a running gateway: aliases, filters, limits, rate, age, packing.
#include <link/serial/serial_settings.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace traffic_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::LinkSettings;
using anogate::Pace;
using anogate::Settings;

constexpr std::uint8_t host = 0xFE;

Bytes check_frame(std::uint8_t source, std::uint8_t destination, const Bytes& of) {
    return frame(source, destination, 0x00, {of[3], of[of.size() - 2], of[of.size() - 1]});
}

// Two sensors with the same factory id, one of them under an alias; a ground station.
class Alias : public testing::Test {
protected:
    Alias() {
        std::vector<LinkSettings> links{port("flow1"), port("flow2"), udp_listen("ground")};
        Settings settings = settings_of(std::move(links));
        settings.aliases = {{"flow2", sensor, alias}};
        daemon = std::make_unique<RunningGateway>(std::move(settings));
        EXPECT_TRUE(daemon->until_up("flow1") && daemon->until_up("flow2"));
        station.send(daemon->port("ground"), frame(host, 0xFF, 0xE0, {0, 0, 0}));
        EXPECT_TRUE(daemon->until([&] { return !flow1.heard().empty() && !flow2.heard().empty(); }));
        said1 = flow1.heard().size();
        said2 = flow2.heard().size();
    }
    LinkSettings port(const std::string& name) {
        LinkSettings link = serial(name, dir / name);
        link.as<anogate::SerialSettings>().pace = Pace::off;
        return link;
    }
    std::vector<Bytes> heard1() { return split(std::span{flow1.heard()}.subspan(said1)).frames; }
    std::vector<Bytes> heard2() { return split(std::span{flow2.heard()}.subspan(said2)).frames; }
    std::vector<Bytes> heard_above() { return split(station.heard()).frames; }

    static constexpr std::uint8_t sensor = 0xDE, alias = 31;
    static constexpr int in_flight = 20;
    const TempDir dir;
    PtyDevice flow1{dir / "flow1"}, flow2{dir / "flow2"};
    UdpPeer station;
    std::unique_ptr<RunningGateway> daemon;
    std::size_t said1 = 0, said2 = 0;
};

TEST_F(Alias, writes_to_a_sensor_under_another_address_are_acknowledged_twenty_in_flight) {
    std::vector<Bytes> writes;
    for (std::uint8_t n = 0; n < in_flight; ++n) {
        writes.push_back(frame(host, alias, 0xE1, {n, 0, n, 0x42}));
        station.send(daemon->port("ground"), writes.back());
    }
    ASSERT_TRUE(daemon->until([&] { return heard2().size() == in_flight; }));
    const auto seen = heard2();
    for (std::uint8_t n = 0; n < in_flight; ++n) EXPECT_EQ(seen[n], frame(host, sensor, 0xE1, {n, 0, n, 0x42}));
    EXPECT_TRUE(heard1().empty()) << "the other sensor is not meant";
    Bytes answers;    // in reverse order: devices need not keep the order
    for (auto write = seen.rbegin(); write != seen.rend(); ++write) answers = answers + check_frame(sensor, host, *write);
    flow2.write(answers);
    ASSERT_TRUE(daemon->until([&] { return heard_above().size() == in_flight; }));
    const auto acknowledged = heard_above();
    for (std::uint8_t n = 0; n < in_flight; ++n)
        EXPECT_EQ(acknowledged[n], check_frame(alias, host, writes[in_flight - 1u - n])) << "the checks of what was sent";
}

TEST_F(Alias, writes_of_the_sensor_are_acknowledged_twenty_in_flight) {
    std::vector<Bytes> writes;
    Bytes all;
    for (std::uint8_t n = 0; n < in_flight; ++n) {
        writes.push_back(frame(sensor, host, 0xE1, {n, 0, 7, n}));
        all = all + writes.back();
    }
    flow2.write(all);
    ASSERT_TRUE(daemon->until([&] { return heard_above().size() == in_flight; }));
    const auto seen = heard_above();
    for (std::uint8_t n = 0; n < in_flight; ++n) EXPECT_EQ(seen[n], frame(alias, host, 0xE1, {n, 0, 7, n}));
    for (const Bytes& write : seen) station.send(daemon->port("ground"), check_frame(host, alias, write));
    ASSERT_TRUE(daemon->until([&] { return heard2().size() == in_flight; }));
    const auto acknowledged = heard2();
    for (std::uint8_t n = 0; n < in_flight; ++n) EXPECT_EQ(acknowledged[n], check_frame(host, sensor, writes[n]));
}

TEST_F(Alias, device_information_of_both_sensors_is_distinguished) {
    const auto who = [](std::uint8_t source, std::uint8_t id) {
        return frame(source, host, 0xE3, {id, 1, 0, 2, 0, 'f', 'l', 'o', 'w'});
    };
    flow1.write(who(sensor, sensor));
    ASSERT_TRUE(daemon->until([&] { return heard_above().size() == 1; }));
    flow2.write(who(sensor, sensor));
    ASSERT_TRUE(daemon->until([&] { return heard_above().size() == 2; }));
    EXPECT_EQ(heard_above()[0], who(sensor, sensor));
    EXPECT_EQ(heard_above()[1], who(alias, alias)) << "the id inside, too";
    EXPECT_TRUE(daemon->status().at("conflicts").empty());
    station.send(daemon->port("ground"), frame(host, sensor, 0xE0, {1, 0, 0}));
    ASSERT_TRUE(daemon->until([&] { return heard1().size() == 1; }));
    EXPECT_TRUE(heard2().empty());
    EXPECT_TRUE(daemon->counters_add_up());
}

// Sensors at rest send equal frames: a frame of one, forwarded to the other's link, is not counted as a copy when the other sends
// it.
TEST_F(Alias, equal_frames_of_both_sensors_are_forwarded) {
    const Bytes flow = frame(sensor, 0xFF, 0x51, {0, 0, 0, 0, 255});
    for (std::size_t n = 0; n < 3; ++n) {
        flow1.write(flow);
        ASSERT_TRUE(daemon->until([&] { return heard_above().size() == 2 * n + 1; })) << n;
        flow2.write(flow);
        ASSERT_TRUE(daemon->until([&] { return heard_above().size() == 2 * n + 2; })) << n;
    }
    EXPECT_EQ(heard_above()[0], flow);
    EXPECT_EQ(heard_above()[1], frame(alias, 0xFF, 0x51, {0, 0, 0, 0, 255}));
    EXPECT_EQ(daemon->count("flow1", "looped"), 0u);
    EXPECT_EQ(daemon->count("flow2", "looped"), 0u);
    EXPECT_TRUE(daemon->counters_add_up());
}

class Traffic : public testing::Test {
protected:
    void start(LinkSettings to, LinkSettings from = udp_listen("air")) {
        to.name = "to";
        daemon = std::make_unique<RunningGateway>(settings_of({std::move(to), std::move(from)}));
        EXPECT_TRUE(daemon->until_up("air"));
    }
    void send(const Bytes& bytes) { air.send(daemon->port("air"), bytes); }
    /// Sends the bytes and waits until the gateway has read them.
    void in(const Bytes& bytes) {
        total += split(bytes).frames.size();
        send(bytes);
        ASSERT_TRUE(daemon->until([&] { return daemon->count("air", "frames_in") == total; }));
    }
    const TempDir dir;
    UdpPeer air, peer;
    std::unique_ptr<RunningGateway> daemon;
    std::uint64_t total = 0;
};

TEST_F(Traffic, filters_drop_received_frames_and_frames_to_be_sent) {
    LinkSettings to = udp("to", peer.local().text()), from = udp_listen("air");
    from.rules.receive.deny = {{0xF0, 0xF0}};
    from.rules.receive.allow_sources = {{0xD0, 0xFE}};
    to.rules.send.allow = {{0x00, 0x0F}, {0xE0, 0xE3}};
    to.rules.send.deny_destinations = {{0xFE, 0xFE}};
    start(to, from);
    in(frame(0xDC, 0xFF, 0x01, {1}) + frame(0xDC, 0xFF, 0xF0, {1, 2}) + frame(0x42, 0xFF, 0x01, {3}) +
       frame(0xDC, 0xFF, 0xA0, {4}) + frame(0xDC, 0xFE, 0x01, {5}) + frame(0xDC, 0xDD, 0x01, {6}));
    ASSERT_TRUE(daemon->until([&] { return split(peer.heard()).frames.size() == 2; }));
    EXPECT_EQ(split(peer.heard()).frames, (std::vector{frame(0xDC, 0xFF, 0x01, {1}), frame(0xDC, 0xDD, 0x01, {6})}));
    EXPECT_EQ(daemon->count("air", "denied_in"), 2u);
    EXPECT_EQ(daemon->count("to", "denied_out"), 2u);
    EXPECT_TRUE(daemon->route("0x42").is_null()) << "nothing is learned from what is refused";
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Traffic, a_rate_limit_applies_to_its_id_only) {
    LinkSettings to = udp("to", peer.local().text());
    to.rules.limit = {{0x03, 5.0}};
    start(to);
    for (std::uint8_t n = 0; n < 50; ++n) in(frame(0xDC, 0xFF, 0x03, {n}) + frame(0xDC, 0xFF, 0x05, {n}));
    ASSERT_TRUE(daemon->until([&] { return daemon->count("to", "frames_out") + daemon->count("to", "limited") == 100; }));
    const auto out = split(peer.heard()).frames;
    EXPECT_EQ(std::count_if(out.begin(), out.end(), [](const Bytes& f) { return f[3] == 0x05; }), 50);
    EXPECT_GE(daemon->count("to", "limited"), 40u) << "the fifty did not take two seconds";
    EXPECT_TRUE(daemon->counters_add_up());
}

// 1000 bytes/s offered 40 times that, for as long as 300 bytes take to be sent.
TEST_F(Traffic, a_rate_limits_udp_and_urgent_frames_overtake_others) {
    LinkSettings to = udp("to", peer.local().text());
    to.rate = 1000;
    to.pack = false;
    start(to);
    const auto begin = anogate::Clock::now();
    Bytes burst;
    for (std::uint8_t n = 0; n < 100; ++n) burst = burst + frame(0xDC, 0xFF, 0xA0, Bytes(13, n));
    in(burst);
    const Bytes stop = frame(0xFE, 0xFF, 0xC0, {1, 2, 3});
    in(stop);
    std::size_t before_stop = 0;
    ASSERT_TRUE(daemon->until([&] {
        const auto out = split(peer.heard()).frames;
        before_stop = static_cast<std::size_t>(std::find(out.begin(), out.end(), stop) - out.begin());
        return before_stop < out.size();
    }));
    EXPECT_LE(before_stop, 4u) << "what was given to the system already";
    ASSERT_TRUE(daemon->until([&] { return peer.heard().size() >= 300; }));
    const double seconds = std::chrono::duration<double>(anogate::Clock::now() - begin).count();
    EXPECT_LE(static_cast<double>(peer.heard().size()), 1000 * seconds + 45) << "never overrun";
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Traffic, frames_that_wait_longer_than_their_maximum_age_are_dropped) {
    LinkSettings to = udp("to", peer.local().text());
    to.rate = 500;
    to.age.telemetry = 50ms;
    start(to);
    Bytes burst;
    for (std::uint8_t n = 0; n < 40; ++n) burst = burst + frame(0xDC, 0xFF, static_cast<std::uint8_t>(n % 8), Bytes(14, n));
    in(burst);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("to", "waiting") == 0; }));
    EXPECT_GE(daemon->count("to", "stale"), 1u);
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Traffic, frames_that_wait_share_datagrams_of_mtu_bytes) {
    LinkSettings to = udp("to", peer.local().text());
    to.mtu = 200;
    start(to);
    Bytes burst;
    for (std::uint8_t n = 0; n < 100; ++n) burst = burst + frame(0xDC, 0xFF, 0xA0, Bytes(13, n));    // 21 bytes each
    in(burst);
    std::vector<Bytes> datagrams;
    std::size_t frames = 0;
    ASSERT_TRUE(daemon->until([&] {
        for (const Bytes& datagram : peer.datagrams()) {
            const Split whole = split(datagram);
            EXPECT_TRUE(whole.rest.empty()) << "a frame is never cut";
            EXPECT_LE(datagram.size(), 200u);
            frames += whole.frames.size();
            datagrams.push_back(datagram);
        }
        return frames == 100;
    }));
    EXPECT_EQ(datagrams.size(), 12u) << "nine in each";
}

TEST_F(Traffic, each_datagram_has_one_frame_if_packing_is_off) {
    LinkSettings to = udp("to", peer.local().text());
    to.pack = false;
    start(to);
    in(frame(0xDC, 0xFF, 0x01, {1}) + frame(0xDC, 0xFF, 0x02, {2}) + frame(0xDC, 0xFF, 0x03, {3}));
    std::size_t datagrams = 0;
    ASSERT_TRUE(daemon->until([&] {
        for (const Bytes& datagram : peer.datagrams()) {
            EXPECT_EQ(split(datagram).frames.size(), 1u);
            ++datagrams;
        }
        return datagrams == 3;
    }));
}

// A line of 11520 bytes/s with a fast reader: only pacing limits it.
TEST_F(Traffic, pacing_sends_no_more_than_a_serial_line_can_carry) {
    PtyDevice device{dir / "port"};
    LinkSettings to = serial("to", device.path());
    to.as<anogate::SerialSettings>().baud = 115200;
    to.as<anogate::SerialSettings>().pace = Pace::on;
    start(to);
    ASSERT_TRUE(daemon->until_up("to"));
    const auto begin = anogate::Clock::now();
    for (std::uint8_t n = 0; n < 100; ++n) in(frame(0xDC, 0xFF, 0xA0, Bytes(60, n)));
    ASSERT_TRUE(daemon->until([&] { return device.heard().size() >= 3000; }));
    const double seconds = std::chrono::duration<double>(anogate::Clock::now() - begin).count();
    EXPECT_LE(static_cast<double>(device.heard().size()), 11520 * (seconds + 0.020) + 68);
    EXPECT_TRUE(split(device.heard()).rest.empty());
    EXPECT_TRUE(daemon->counters_add_up());
}

// At 9600 baud, frames of two hosts for three seconds already wait.
TEST_F(Traffic, a_third_host_does_not_wait_for_two_that_flood_a_line) {
    PtyDevice device{dir / "port"};
    LinkSettings to = serial("to", device.path());
    to.as<anogate::SerialSettings>().baud = 9600;
    to.as<anogate::SerialSettings>().pace = Pace::on;
    start(to);
    ASSERT_TRUE(daemon->until_up("to"));
    UdpPeer second, third;
    for (std::uint8_t n = 0; n < 100; ++n) {
        in(frame(host, 0xDC, 0xE1, {n, 0, 1, 0, 0, 0}));
        ++total;
        second.send(daemon->port("air"), frame(host, 0xDC, 0xE1, {n, 0, 2, 0, 0, 0}));
    }
    ASSERT_TRUE(daemon->until([&] { return daemon->count("air", "frames_in") == total; }));
    for (std::uint8_t n = 0; n < 5; ++n) {
        const Bytes command = frame(host, 0xDC, 0xC0, {n, 2, 3});
        ++total;
        third.send(daemon->port("air"), command);
        ASSERT_TRUE(daemon->until([&] { return daemon->count("air", "frames_in") == total; }));
        const std::size_t before = split(device.heard()).frames.size();
        std::size_t place = 0;
        ASSERT_TRUE(daemon->until([&] {
            const auto out = split(device.heard()).frames;
            const auto at = std::find(out.begin(), out.end(), command);
            place = static_cast<std::size_t>(at - out.begin());
            return at != out.end();
        }));
        EXPECT_LE(place, before + 4u) << "two frames, and what was given to the driver in 20 ms";
    }
    EXPECT_GT(daemon->count("to", "waiting"), 100u);
    EXPECT_EQ(daemon->count("to", "queue_full"), 0u);
    EXPECT_TRUE(daemon->counters_add_up());
}

}    // namespace
}    // namespace traffic_tests
