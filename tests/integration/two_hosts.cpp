// Two hosts that send the same bytes: a peer's frames arrive, however often another sender has sent the same before.
#include <link/serial/serial_settings.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace two_hosts_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

const Bytes lock = frame(0xFE, 0xFF, 0xC0, {0x10, 0, 2});
const Bytes unlock = frame(0xFE, 0xFF, 0xC0, {0x10, 0, 1});
const Bytes addressed = frame(0xFE, 0xDC, 0xC0, {0x10, 0, 2});    // to an unknown device
const Bytes question = frame(0xFE, 0xFF, 0xE0, {0, 0, 0});

// Both are peers of one link, or each has its own link; the device is on a cable.
class TwoHosts : public testing::TestWithParam<bool> {
protected:
    TwoHosts() {
        anogate::LinkSettings cable = serial("device", dir / "device");
        cable.as<anogate::SerialSettings>().pace = anogate::Pace::off;
        std::vector<anogate::LinkSettings> links{cable, udp_listen("ground")};
        if (GetParam()) links.push_back(udp_listen("tower"));
        gateway = std::make_unique<RunningGateway>(settings_of(std::move(links)));
        EXPECT_TRUE(gateway->until_up("device") && gateway->until_up("ground"));
        send(first, question);
        send(second, question);
    }
    const char* link_of(const UdpPeer& host) const { return GetParam() && &host == &second ? "tower" : "ground"; }
    void send(UdpPeer& host, const Bytes& what) {
        const std::size_t before = arrived();
        host.send(gateway->port(link_of(host)), what);
        EXPECT_TRUE(gateway->until([&] { return arrived() > before; }, 2s)) << "a frame of a host is lost";
        EXPECT_EQ(arrived(), before + 1);
    }
    std::size_t arrived() { return split(device.heard()).frames.size(); }
    std::uint64_t looped() { return gateway->count("ground", "looped") + (GetParam() ? gateway->count("tower", "looped") : 0); }

    const TempDir dir;
    PtyDevice device{dir / "device"};
    UdpPeer first, second;
    std::unique_ptr<RunningGateway> gateway;
};

TEST_P(TwoHosts, can_both_lock_and_unlock) {
    for (int i = 0; i < 8; ++i) {
        send(first, lock);
        send(first, unlock);
        send(second, lock);
    }
    EXPECT_EQ(arrived(), 2u + 8 * 3);
    EXPECT_EQ(looped(), 0u);
    EXPECT_TRUE(gateway->counters_add_up());
}

TEST_P(TwoHosts, can_both_send_commands_to_a_device_that_was_never_seen) {
    for (int i = 0; i < 8; ++i) {
        send(first, addressed);
        send(second, addressed);
        send(second, addressed);
    }
    EXPECT_EQ(looped(), 0u);
}

TEST_P(TwoHosts, receive_at_most_one_probe_a_second_from_the_gateway) {
    const auto begin = anogate::Clock::now();
    for (int i = 0; i < 30; ++i) {
        send(first, lock);
        send(second, lock);
    }
    const auto seconds = static_cast<std::size_t>((anogate::Clock::now() - begin) / 1s);
    for (UdpPeer* host : {&first, &second}) {
        std::size_t probes = 0;
        for (const Bytes& heard : split(host->heard()).frames) probes += heard[3] == 0xFB;
        EXPECT_LE(probes, seconds + 2);    // and those for the questions at the start
    }
    for (const Bytes& heard : split(device.heard()).frames) EXPECT_NE(heard[3], 0xFB) << "never on a cable";
}

// The vendor's bridges forward only frames from 0xFE to 0xFF: one of them connects two of our links.
class Bridged : public testing::Test {
protected:
    Bridged() {
        anogate::LinkSettings cable = serial("device", dir / "device");
        cable.as<anogate::SerialSettings>().pace = anogate::Pace::off;
        gateway = std::make_unique<RunningGateway>(
            settings_of({cable, udp_listen("ground"), udp("radio", left.local().text()), udp("wifi", right.local().text())}));
        EXPECT_TRUE(gateway->until_up("device") && gateway->until_up("radio") && gateway->until_up("wifi"));
    }
    void forward() {
        pass(left, right, from_left);
        pass(right, left, from_right);
    }
    void pass(UdpPeer& in, UdpPeer& out, std::size_t& frames) {
        for (const Bytes& datagram : in.datagrams())
            for (const Bytes& one : split(datagram).frames) {
                ++frames;
                if (one[1] != 0xFE || one[2] != 0xFF) continue;
                waiting.emplace_back(&out, one);
            }
        ours[&in] = in.last_sender();
        for (auto it = waiting.begin(); it != waiting.end();)
            if (ours[it->first].port != 0) {
                it->first->send(ours[it->first], it->second);
                it = waiting.erase(it);
            } else {
                ++it;
            }
    }
    bool until(const std::function<bool()>& holds, anogate::Duration limit = patience) {
        return gateway->until(
            [&] {
                forward();
                return holds();
            },
            limit);
    }
    std::size_t times(const Bytes& what) {
        std::size_t n = 0;
        for (const Bytes& one : split(device.heard()).frames) n += one == what;
        return n;
    }

    const TempDir dir;
    PtyDevice device{dir / "device"};
    UdpPeer left, right, host;
    std::map<UdpPeer*, anogate::Endpoint> ours;
    std::vector<std::pair<UdpPeer*, Bytes>> waiting;
    std::size_t from_left = 0, from_right = 0;
    std::unique_ptr<RunningGateway> gateway;
};

TEST_F(Bridged, a_command_passes_at_most_three_times_and_later_ones_once) {
    for (std::uint8_t n = 0; n < 4; ++n) {
        const Bytes what = frame(0xFE, 0xFF, 0xC0, {0x10, 0, n});
        host.send(gateway->port("ground"), what);
        ASSERT_TRUE(until([&] { return times(what) > 0; }));
        std::size_t before = 0;
        ASSERT_TRUE(until([&, quiet = 0]() mutable {
            const std::size_t now = from_left + from_right;
            quiet = now == before ? quiet + 1 : 0;
            before = now;
            return quiet == 300 && waiting.empty();
        }));
        EXPECT_LE(times(what), n == 0 ? 3u : 1u);
    }
    EXPECT_TRUE(std::string{gateway->link("wifi").at("hint")}.starts_with("loop: frames sent to "));
    EXPECT_LE(from_left + from_right, 50u);
    EXPECT_TRUE(gateway->counters_add_up());
}

// Two serial ports with connected lines: no probe is sent on them.
class Cabled : public testing::Test {
protected:
    Cabled() {
        std::vector<anogate::LinkSettings> links{udp_listen("ground")};
        for (const char* name : {"device", "radio", "wifi"}) {
            links.push_back(serial(name, dir / name));
            links.back().as<anogate::SerialSettings>().pace = anogate::Pace::off;
        }
        gateway = std::make_unique<RunningGateway>(settings_of(std::move(links)));
        EXPECT_TRUE(gateway->until_up("device") && gateway->until_up("radio") && gateway->until_up("wifi"));
    }
    void join(PtyDevice& from, PtyDevice& to, Bytes& waiting) {
        const Bytes more = from.read();
        circulated += more.size();
        waiting = waiting + more;
        waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(to.write(waiting)));
    }
    bool until(const std::function<bool()>& holds) {
        return gateway->until([&] {
            join(left, right, to_right);
            join(right, left, to_left);
            return holds();
        });
    }
    bool until_quiet() {
        return until([&, before = circulated, quiet = 0]() mutable {
            quiet = before == circulated && to_left.empty() && to_right.empty() ? quiet + 1 : 0;
            before = circulated;
            return quiet == 100;
        });
    }
    static Bytes order(std::uint8_t n) { return frame(0xFE, 0xFF, 0xC0, {0x10, 0, n}); }
    std::ptrdiff_t times(const Bytes& what) {
        const auto frames = split(device.heard()).frames;
        return std::count(frames.begin(), frames.end(), what);
    }

    const TempDir dir;
    PtyDevice device{dir / "device"}, left{dir / "radio"}, right{dir / "wifi"};
    UdpPeer host;
    Bytes to_left, to_right;
    std::size_t circulated = 0;
    std::unique_ptr<RunningGateway> gateway;
};

// Enough commands for 200 copies in a second on any machine.
TEST_F(Cabled, a_loop_is_cut_and_reported_and_later_commands_pass_once) {
    for (std::uint8_t n = 0; n < 100; ++n) host.send(gateway->port("ground"), order(n));
    ASSERT_TRUE(until([&] { return std::string{gateway->link("wifi").at("hint")}.starts_with("loop: frames sent to "); }));
    ASSERT_TRUE(until_quiet()) << "nothing circulates";
    EXPECT_GT(gateway->count("radio", "looped") + gateway->count("wifi", "looped"), 0u);
    for (std::uint8_t n = 100; n < 110; ++n) host.send(gateway->port("ground"), order(n));
    ASSERT_TRUE(until([&] { return times(order(109)) > 0; }));
    ASSERT_TRUE(until_quiet());
    for (std::uint8_t n = 0; n < 110; ++n) EXPECT_GE(times(order(n)), 1) << int{n};
    for (std::uint8_t n = 100; n < 110; ++n) EXPECT_EQ(times(order(n)), 1) << int{n};
    EXPECT_TRUE(gateway->counters_add_up());
}

INSTANTIATE_TEST_SUITE_P(Links, TwoHosts, testing::Bool(),
                         [](const auto& two) { return std::string{two.param ? "on_two_links" : "on_one_link"}; });

}    // namespace
}    // namespace two_hosts_tests
