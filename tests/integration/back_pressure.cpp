// Slow and stopped readers: whole frames in their order, bounded memory, every drop counted.
#include <link/serial/serial_settings.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace back_pressure_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::LinkSettings;
using anogate::Pace;

Bytes numbered(std::uint32_t n) {
    Bytes data(13 + n % 60, 0xAB);    // full of false headers with many lengths
    for (std::size_t i = 0; i < 4; ++i) data[i] = static_cast<std::uint8_t>(n >> (8 * i));
    return frame(0xDC, 0xFE, 0xF1, data);
}
std::uint32_t number_of(const Bytes& frame) {
    return static_cast<std::uint32_t>(frame[6] | frame[7] << 8 | frame[8] << 16 | frame[9] << 24);
}

/// Only whole frames, in increasing order.
testing::AssertionResult whole_and_in_order(const Bytes& stream, std::size_t& count, std::uint32_t& last) {
    const Split heard = split(stream);
    if (!heard.rest.empty()) return testing::AssertionFailure() << heard.rest.size() << " bytes that are no frame";
    count = heard.frames.size();
    std::int64_t before = -1;
    for (const Bytes& f : heard.frames) {
        if (f != numbered(number_of(f))) return testing::AssertionFailure() << "a frame that nobody sent";
        if (number_of(f) <= before) return testing::AssertionFailure() << number_of(f) << " after " << before;
        before = number_of(f);
    }
    last = static_cast<std::uint32_t>(before);
    return testing::AssertionSuccess();
}

// As fast as the reader accepts data, without pacing.
LinkSettings unpaced(const std::string& name, const std::string& device) {
    LinkSettings link = serial(name, device);
    link.as<anogate::SerialSettings>().pace = Pace::off;
    return link;
}

TEST(BackPressure, a_reader_of_a_few_bytes_at_a_time_gets_whole_frames_only) {
    const TempDir dir;
    PtyDevice slow{dir / "slow"};
    auto link = unpaced("slow", slow.path());
    link.queue = 8 * 1024;
    RunningGateway daemon{link, udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("slow"));
    UdpPeer air;
    Bytes got;
    std::uint32_t n = 0;
    while (n < 6000) {
        for (int i = 0; i < 8; ++i) air.send(daemon.port("air"), numbered(n++));
        daemon.until([&] { return daemon.count("air", "frames_in") == n; });
        got = got + slow.read(7 + n % 31);
        ASSERT_TRUE(daemon.counters_add_up());
        const auto& outbox = daemon.gateway().forwarder().channel(anogate::ChannelId{0}).outbox;
        ASSERT_LE(outbox.waiting_bytes(), link.queue + 100);
    }
    EXPECT_GT(daemon.count("slow", "queue_full"), 1000u);
    ASSERT_TRUE(daemon.until([&] {
        got = got + slow.read();
        return daemon.count("slow", "waiting") == 0;
    }));
    daemon.run_for(5ms);
    got = got + slow.heard();
    std::size_t count = 0;
    std::uint32_t last = 0;
    EXPECT_TRUE(whole_and_in_order(got, count, last));
    EXPECT_EQ(count, daemon.count("slow", "frames_out"));
    EXPECT_EQ(count + daemon.count("slow", "queue_full"), n);
    EXPECT_EQ(last, n - 1) << "the newest is not what was dropped";
}

TEST(BackPressure, a_reader_that_pauses_and_resumes_receives_only_whole_frames) {
    const TempDir dir;
    PtyDevice slow{dir / "slow"}, other{dir / "other"};
    RunningGateway daemon{unpaced("slow", slow.path()), unpaced("other", other.path()), udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("slow") && daemon.until_up("other"));
    UdpPeer air;
    std::uint32_t n = 0;
    Bytes got;
    for (int pause = 0; pause < 3; ++pause) {
        const auto until = n + 2000;
        while (n < until) {
            air.send(daemon.port("air"), numbered(n++));
            daemon.until([&] { return daemon.count("air", "frames_in") == n; });
            other.heard();
        }
        EXPECT_TRUE(daemon.until([&] {
            got = got + slow.read();
            other.heard();
            return daemon.count("slow", "waiting") == 0 && daemon.count("other", "waiting") == 0;
        }));
    }
    daemon.run_for(5ms);
    got = got + slow.heard();
    std::size_t count = 0;
    std::uint32_t last = 0;
    EXPECT_TRUE(whole_and_in_order(got, count, last));
    EXPECT_EQ(last, n - 1);
    EXPECT_GT(daemon.count("slow", "queue_full"), 0u);
    EXPECT_TRUE(whole_and_in_order(other.heard(), count, last));
    EXPECT_EQ(count, n) << "who reads, loses nothing";
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(BackPressure, a_reader_unplugged_in_the_middle_of_a_frame_starts_with_a_whole_one) {
    const TempDir dir;
    PtyDevice slow{dir / "slow"};
    RunningGateway daemon{unpaced("slow", slow.path()), udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("slow"));
    UdpPeer air;
    std::uint32_t n = 0;
    const auto send = [&] {
        air.send(daemon.port("air"), numbered(n++));
        return daemon.until([&] { return daemon.count("air", "frames_in") == n; });
    };
    while (daemon.count("slow", "waiting") < 20) ASSERT_TRUE(send());
    slow.unplug();
    ASSERT_TRUE(daemon.until_waiting("slow"));
    EXPECT_GE(daemon.count("slow", "link_down"), 20u);
    slow.plug();
    ASSERT_TRUE(daemon.until_up("slow"));
    ASSERT_TRUE(send());
    EXPECT_TRUE(daemon.until([&] { return slow.heard() == numbered(n - 1); })) << "nothing old, nothing torn";
    EXPECT_TRUE(daemon.counters_add_up());
}

// A full wire is noticed because it accepts no more bytes, paced or not: from then on newer telemetry replaces older.
TEST(BackPressure, a_stuck_reader_without_pacing_receives_the_newest_telemetry_once_it_reads_again) {
    const TempDir dir;
    PtyDevice stuck{dir / "stuck"};
    RunningGateway daemon{unpaced("stuck", stuck.path()), udp_listen("air")};
    ASSERT_TRUE(daemon.until_up("stuck"));
    UdpPeer air;
    std::uint64_t n = 0;
    const auto send = [&](const Bytes& bytes) {
        air.send(daemon.port("air"), bytes);
        ++n;
        return daemon.until([&] { return daemon.count("air", "frames_in") == n; });
    };
    std::uint32_t number = 0;
    while (daemon.count("stuck", "waiting") < 2) ASSERT_TRUE(send(numbered(number++)));
    const auto before = daemon.count("stuck", "waiting");
    Bytes newest;
    for (std::uint8_t i = 0; i < 20; ++i) ASSERT_TRUE(send(newest = frame(0xDC, 0xFE, 0x03, {i, 2, 3, 4, 5, 6, 0})));
    EXPECT_EQ(daemon.count("stuck", "superseded"), 19u);
    EXPECT_EQ(daemon.count("stuck", "waiting"), before + 1);
    ASSERT_TRUE(daemon.until([&] {
        stuck.heard();
        return daemon.count("stuck", "waiting") == 0;
    })) << "nobody says anything more: the wire tells that it takes again";
    daemon.run_for(5ms);
    const auto frames = split(stuck.heard()).frames;
    EXPECT_EQ(std::count(frames.begin(), frames.end(), newest), 1);
    EXPECT_EQ(std::count_if(frames.begin(), frames.end(), [](const Bytes& f) { return f[3] == 0x03; }), 1);
    EXPECT_TRUE(daemon.counters_add_up());
}

// The rest of the time is for frames that wait.
TEST(BackPressure, nothing_is_read_while_the_shutdown_waits_for_a_slow_reader) {
    const TempDir dir;
    PtyDevice stuck{dir / "stuck"}, device{dir / "device"};
    UdpPeer fixed, air, late;
    RunningGateway daemon{unpaced("stuck", stuck.path()), serial("device", device.path()), pty("app", dir / "app"),
                          udp("fixed", fixed.local().text()), udp_listen("air")};
    PortUser app{dir / "app"};
    ASSERT_TRUE(daemon.until_up("stuck") && daemon.until_up("device") && daemon.until_up("app") && daemon.until_up("fixed"));
    const auto fixed_port = daemon.port("fixed"), air_port = daemon.port("air");
    for (std::uint32_t n = 0; daemon.count("stuck", "waiting") < 2; ++n) {
        air.send(air_port, numbered(n));
        ASSERT_TRUE(daemon.until([&] { return daemon.count("air", "frames_in") == n + 1; }));
        app.heard(), device.heard(), fixed.heard(), air.heard();
    }
    std::map<std::string, std::uint64_t> before, after;
    const auto look = [&](auto& counts) {
        for (const char* link : {"stuck", "device", "app", "fixed", "air"}) counts[link] = daemon.count(link, "frames_in");
    };
    look(before);
    int turns = 0;
    daemon.stop(100ms, [&] {
        if (++turns > 3) return;
        stuck.write(vendor::i_am_an_mcu);
        device.write(vendor::i_am_an_mcu);
        app.write(vendor::i_am_an_mcu);
        fixed.send(fixed_port, vendor::i_am_an_mcu);
        air.send(air_port, vendor::i_am_an_mcu);
        late.send(air_port, vendor::i_am_an_mcu);
    });
    EXPECT_GT(turns, 3);
    look(after);
    EXPECT_EQ(after, before);
}

TEST(BackPressure, a_flood_is_forwarded_or_counted_frame_by_frame) {
    const TempDir dir;
    UdpPeer air, host;
    auto one_by_one = udp("host", host.local().text());
    one_by_one.pack = false;
    RunningGateway daemon{one_by_one, udp_listen("air")};
    std::uint32_t n = 0;
    std::size_t heard = 0;
    Bytes got;
    for (int burst = 0; burst < 50; ++burst) {
        for (int i = 0; i < 100; ++i) air.send(daemon.port("air"), numbered(n++));
        daemon.io().restart();
        daemon.io().poll();
        for (const Bytes& datagram : host.datagrams()) {
            ++heard;
            got = got + datagram;
        }
    }
    EXPECT_TRUE(daemon.until([&] {
        for (const Bytes& datagram : host.datagrams()) {
            ++heard;
            got = got + datagram;
        }
        return heard >= daemon.count("host", "frames_out") &&
               daemon.count("air", "frames_in") + daemon.link("air").at("kernel_drops").get<std::uint64_t>() == n;
    }));
    std::size_t count = 0;
    std::uint32_t last = 0;
    EXPECT_TRUE(whole_and_in_order(got, count, last));
    EXPECT_EQ(count, daemon.count("air", "frames_in"));
    EXPECT_TRUE(daemon.counters_add_up());
}

}    // namespace
}    // namespace back_pressure_tests
