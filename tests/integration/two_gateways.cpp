// Two gateways joined by two UDP links, each direction with its own delay: every broadcast arrives, nothing goes round, and
// with the links in one group a command arrives exactly once.
#include <support/pty_device.hpp>
#include <support/relay.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>

namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::Duration;
using anogate::LinkSettings;

struct Delays {
    Duration first_there, first_back, second_there, second_back;
};

// How often each frame arrived, by its bytes.
using Times = std::map<std::string, int>;
std::string key(const Bytes& frame) { return {frame.begin(), frame.end()}; }

class JoinedGateways : public testing::TestWithParam<Delays> {
protected:
    void start(const std::string& group) {
        const Delays d = GetParam();
        relays[0] = std::make_unique<Relay>(d.first_there, d.first_back);
        relays[1] = std::make_unique<Relay>(d.second_there, d.second_back);
        a = std::make_unique<RunningGateway>(settings_of({device("a"), way(0, true, group), way(1, true, group)}));
        b = std::make_unique<RunningGateway>(settings_of({device("b"), way(0, false, group), way(1, false, group)}));
        ASSERT_TRUE(until([&] { return a->link("device").at("state") == "up" && b->link("device").at("state") == "up"; }));
        // From here on every relay knows both of its sides, and every gateway has heard by both links.
        for (int i : {0, 1}) {
            at_a.write(frame(0xDC, 0xFF, 0x01, {static_cast<std::uint8_t>(i)}));
            at_b.write(frame(0xDD, 0xFF, 0x01, {static_cast<std::uint8_t>(i)}));
            ASSERT_TRUE(until_quiet());
        }
        heard(at_a);
        heard(at_b);
    }
    LinkSettings device(const std::string& name) {
        LinkSettings link = serial("device", dir / name);
        link.serial.pace = anogate::Pace::off;
        return link;
    }
    LinkSettings way(std::size_t number, bool side_a, const std::string& group) const {
        const Relay& relay = *relays[number];
        LinkSettings link = udp("way" + std::to_string(number + 1), side_a ? relay.a() : relay.b());
        link.group = group;
        return link;
    }

    void turn() {
        for (RunningGateway* gateway : {a.get(), b.get()}) {
            gateway->io().restart();
            gateway->io().run_one_for(200us);
            gateway->io().poll();
        }
        for (auto& relay : relays) relay->pump();
    }
    bool until(const std::function<bool()>& holds) {
        return wait_until(holds, patience, [this] { turn(); });
    }
    /// Until nothing is on its way and nothing comes for a while.
    bool until_quiet() {
        constexpr int turns = 50;
        int quiet = 0;
        std::size_t carried = 0;
        return until([&] {
            const std::size_t now = relays[0]->carried() + relays[1]->carried();
            quiet = now == carried && relays[0]->idle() && relays[1]->idle() ? quiet + 1 : 0;
            carried = now;
            return quiet == turns;
        });
    }
    /// How often each frame arrived at the device since the last call.
    static Times heard(PtyDevice& device) {
        Times times;
        Bytes stream;
        for (Bytes more = device.read(); !more.empty(); more = device.read()) stream = std::move(stream) + more;
        const Split got = split(stream);
        EXPECT_TRUE(got.rest.empty()) << "bytes that are no whole frame";
        for (const Bytes& one : got.frames) ++times[key(one)];
        return times;
    }
    static Bytes numbered(std::uint8_t source, std::uint8_t destination, std::uint8_t id, int n) {
        return frame(source, destination, id, {1, 0, 0, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
    }
    static void add(Times& all, const Times& more) {
        for (const auto& [frame, times] : more) all[frame] += times;
    }
    bool counters_add_up() { return a->counters_add_up() && b->counters_add_up(); }

    const TempDir dir;
    PtyDevice at_a{dir / "a"}, at_b{dir / "b"};
    std::unique_ptr<Relay> relays[2];
    std::unique_ptr<RunningGateway> a, b;
};

TEST_P(JoinedGateways, every_broadcast_arrives_once_and_nothing_goes_round) {
    for (const std::string group : {"", "vehicle"}) {
        SCOPED_TRACE(group);
        start(group);
        if (HasFatalFailure()) return;
        constexpr int count = 40;
        const std::size_t before = relays[0]->carried() + relays[1]->carried();
        Times got_a, got_b;
        for (int n = 0; n < count; ++n) {
            at_a.write(numbered(0xDC, 0xFF, 0x20, n));
            at_b.write(numbered(0xDD, 0xFF, 0x20, n));
            for (int i = 0; i < 5; ++i) turn();
        }
        ASSERT_TRUE(until_quiet()) << "something goes round";
        add(got_a, heard(at_a));
        add(got_b, heard(at_b));
        for (int n = 0; n < count; ++n) {
            EXPECT_EQ(got_b[key(numbered(0xDC, 0xFF, 0x20, n))], 1) << n;
            EXPECT_EQ(got_a[key(numbered(0xDD, 0xFF, 0x20, n))], 1) << n;
        }
        EXPECT_EQ(got_a.size(), std::size_t{count}) << "a device does not hear itself";
        EXPECT_LE(relays[0]->carried() + relays[1]->carried() - before, 2u * 4 * count);
        EXPECT_TRUE(counters_add_up());
    }
}

// The ring is known from what the devices said; the links are named.
TEST_P(JoinedGateways, a_hosts_command_to_everybody_arrives_once) {
    start("");
    if (HasFatalFailure()) return;
    constexpr int count = 20;
    for (int n = 0; n < count; ++n) {
        at_a.write(numbered(0xFE, 0xFF, 0xC0, n));
        for (int i = 0; i < 5; ++i) turn();
    }
    ASSERT_TRUE(until_quiet()) << "something goes round";
    const Times got = heard(at_b);
    for (int n = 0; n < count; ++n) EXPECT_EQ(got.count(key(numbered(0xFE, 0xFF, 0xC0, n))) ? got.at(key(numbered(0xFE, 0xFF, 0xC0, n))) : 0, 1) << n;
    for (auto& gateway : {a.get(), b.get()})
        for (const char* way : {"way1", "way2"}) {
            const std::string hint = gateway->link(way).at("hint");
            EXPECT_TRUE(hint == "a ring: what goes out by way1 comes back by way2" ||
                        hint == "a ring: what goes out by way2 comes back by way1") << hint;
        }
    EXPECT_TRUE(counters_add_up());
}

TEST_P(JoinedGateways, a_command_over_a_group_arrives_exactly_once) {
    start("vehicle");
    if (HasFatalFailure()) return;
    constexpr int count = 60;
    Times got;
    for (int n = 0; n < count; ++n) {
        at_b.write(numbered(0xDD, 0xFE, 0x03, n));    // the vehicle talks all the time
        at_a.write(numbered(0xFE, 0xDD, 0xC0, n));
        for (int i = 0; i < 5; ++i) turn();
    }
    ASSERT_TRUE(until_quiet());
    add(got, heard(at_b));
    for (int n = 0; n < count; ++n) EXPECT_EQ(got[key(numbered(0xFE, 0xDD, 0xC0, n))], 1) << n;
    EXPECT_TRUE(counters_add_up());
}

// The link that carries falls silent: what was on its way is lost, and what is sent until its silence shows; never does one
// come twice.
TEST_P(JoinedGateways, when_a_link_of_a_group_falls_silent_the_other_takes_over) {
    for (std::size_t failing : {0u, 1u}) {
        SCOPED_TRACE(failing);
        start("vehicle");
        if (HasFatalFailure()) return;
        Times got;
        int n = 0;
        const auto say = [&] {
            at_b.write(numbered(0xDD, 0xFE, 0x03, n));
            at_a.write(numbered(0xFE, 0xDD, 0xC0, n));
            ++n;
            for (int i = 0; i < 5; ++i) turn();
            heard(at_a);
        };
        while (n < 30) say();
        ASSERT_TRUE(until_quiet());
        relays[failing]->fail();
        const int failed_at = n;
        int taken_over = 0;    // the first command that arrived after the failure
        ASSERT_TRUE(until([&] {
            say();
            add(got, heard(at_b));
            for (taken_over = failed_at; taken_over < n && got.count(key(numbered(0xFE, 0xDD, 0xC0, taken_over))) == 0;)
                ++taken_over;
            return taken_over < n;
        })) << "nothing arrives any more";
        const int end = n + 30;
        while (n < end) say();
        ASSERT_TRUE(until_quiet());
        add(got, heard(at_b));
        for (const auto& [bytes, times] : got) EXPECT_EQ(times, 1);
        for (int i = taken_over; i < n; ++i) EXPECT_EQ(got[key(numbered(0xFE, 0xDD, 0xC0, i))], 1) << i;
        EXPECT_TRUE(counters_add_up());
    }
}

std::string name_of(const testing::TestParamInfo<Delays>& info) {
    const auto ms = [](Duration d) { return std::to_string(d / 1ms); };
    const Delays& d = info.param;
    return ms(d.first_there) + '_' + ms(d.first_back) + "_and_" + ms(d.second_there) + '_' + ms(d.second_back);
}

// Every pair of delays of one link's two directions beside every other of the other's would be 81: those that differ most.
INSTANTIATE_TEST_SUITE_P(Delays, JoinedGateways,
                         testing::Values(Delays{0ms, 0ms, 0ms, 0ms}, Delays{60ms, 60ms, 60ms, 60ms},
                                         Delays{500ms, 500ms, 500ms, 500ms}, Delays{0ms, 0ms, 500ms, 500ms},
                                         Delays{60ms, 500ms, 0ms, 0ms}, Delays{500ms, 0ms, 0ms, 500ms},
                                         Delays{0ms, 60ms, 60ms, 500ms}, Delays{500ms, 60ms, 60ms, 0ms}),
                         name_of);

}    // namespace
