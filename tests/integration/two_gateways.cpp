// Two gateways connected by two UDP links, each direction with its own delay: every broadcast arrives, no frame loops, and with
// the links in one group a command arrives exactly once.
#include <link/serial/serial_settings.hpp>
#include <support/pty_device.hpp>
#include <support/relay.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <utility>

namespace two_gateways_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::Duration;
using anogate::LinkSettings;

struct Delays {
    Duration first_there, first_back, second_there, second_back;

    Duration slowest() const { return std::max({first_there, first_back, second_there, second_back}); }
};

// How often each frame arrived, by its bytes.
using Times = std::map<std::string, int>;
std::string key(const Bytes& frame) { return {frame.begin(), frame.end()}; }

// The description of unexpected frames in a failure message.
std::string in_hex(const Times& frames) {
    std::string text;
    for (const auto& [frame, times] : frames) {
        for (const char byte : frame) {
            char digits[3];
            std::snprintf(digits, sizeof digits, "%02X", static_cast<unsigned char>(byte));
            text += digits;
        }
        text += " x " + std::to_string(times) + "\n";
    }
    return text;
}

class JoinedGateways : public testing::TestWithParam<Delays> {
protected:
    void start(const std::string& group) {
        unfinished.clear();
        const Delays d = GetParam();
        relays[0] = std::make_unique<Relay>(d.first_there, d.first_back);
        relays[1] = std::make_unique<Relay>(d.second_there, d.second_back);
        a = std::make_unique<RunningGateway>(settings_of({device("a"), way(0, true, group), way(1, true, group)}));
        b = std::make_unique<RunningGateway>(settings_of({device("b"), way(0, false, group), way(1, false, group)}));
        ASSERT_TRUE(until([&] { return a->link("device").at("state") == "up" && b->link("device").at("state") == "up"; }));
        const auto from_a = [](int n) { return frame(0xDC, 0xFF, 0x01, {static_cast<std::uint8_t>(n)}); };
        const auto from_b = [](int n) { return frame(0xDD, 0xFF, 0x01, {static_cast<std::uint8_t>(n)}); };
        // A relay loses some frames until it knows both of its sides. After the first frame has arrived, no earlier one is still
        // in a pty, which keeps the order. On a busy machine a pty may delay bytes longer than the quiet time.
        Times got_a, got_b;
        bool have_met = false;
        for (int i = 0; i < 20 && !have_met; ++i) {
            at_a.write(from_a(i));
            at_b.write(from_b(i));
            const auto have_arrived = [&] {
                add(got_a, heard(at_a));
                add(got_b, heard(at_b));
                return got_a.count(key(from_b(i))) > 0 && got_b.count(key(from_a(i))) > 0;
            };
            wait_until(have_arrived, i * 20ms + (i < 2 ? Duration{} : d.slowest()), [this] { turn(); });
            ASSERT_TRUE(until_quiet());
            have_met = have_arrived() && i >= 2;
        }
        ASSERT_TRUE(have_met);
    }
    LinkSettings device(const std::string& name) {
        LinkSettings link = serial("device", dir / name);
        link.as<anogate::SerialSettings>().pace = anogate::Pace::off;
        return link;
    }
    LinkSettings way(std::size_t number, bool side_a, const std::string& group) const {
        const Relay& relay = *relays[number];
        LinkSettings link = udp("way" + std::to_string(number + 1), side_a ? relay.a() : relay.b());
        link.group = group;
        return link;
    }

    void turn() {
        const auto now = anogate::Clock::now();
        max_turn = std::max<Duration>(max_turn, now - std::exchange(last_turn, now));
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
    // The result of a run.
    struct Seen {
        Times at_a, at_b;
        int first = 0, end = 0;    // the numbers of the commands that had to arrive
        std::size_t carried = 0;
        bool came = true;    // all required frames arrived, and then it was quiet
        bool adds_up = false;
        bool disturbed = false;    // the machine stalled: the run proves nothing
    };
    /// Copies are recognised within 2 s: if the machine stalled for a long time, a run proves nothing. It is then repeated, at
    /// most twice.
    template <class Run>
    Seen undisturbed(Run run) {
        constexpr Duration stood_still = 1s;
        for (int runs = 1;; ++runs) {
            max_turn = {};
            last_turn = anogate::Clock::now();
            Seen seen = run();
            seen.disturbed = max_turn >= stood_still;
            if (HasFailure() || !seen.disturbed || runs == 3) return seen;
        }
    }
    /// Waits until `device` has received the frames first to end - 1 numbered by `make`, and adds them to `got`. The kernel
    /// chooses when a pty forwards the written bytes, so a fixed number of turns would not be enough.
    template <class Make>
    bool until_heard(PtyDevice& device, Times& got, int first, int end, Make make) {
        return until([&] {
            add(got, heard(device));
            for (; first < end && got.count(key(make(first))) > 0; ++first) {}
            return first == end;
        });
    }
    /// Until no frame is on its way and none arrives for a while.
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
    /// How often each frame arrived at the device since the last call. A frame that the pty has forwarded partly is counted when
    /// it is complete.
    Times heard(PtyDevice& device) {
        Times times;
        Bytes& stream = unfinished[&device];
        for (Bytes more = device.read(); !more.empty(); more = device.read()) stream = std::move(stream) + more;
        Split got = split(stream);
        stream = std::move(got.rest);
        for (const Bytes& one : got.frames) ++times[key(one)];
        return times;
    }
    static Bytes numbered(std::uint8_t source, std::uint8_t destination, std::uint8_t id, int n) {
        return frame(source, destination, id, {1, 0, 0, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
    }
    static void add(Times& all, const Times& more) {
        for (const auto& [frame, times] : more) all[frame] += times;
    }
    bool adds_up() {
        EXPECT_TRUE(unfinished[&at_a].empty() && unfinished[&at_b].empty()) << "bytes that are no whole frame";
        return a->counters_add_up() && b->counters_add_up();
    }

    static constexpr char held_up[] = "this machine stands still for seconds";
    std::map<PtyDevice*, Bytes> unfinished;
    Duration max_turn{};
    anogate::TimePoint last_turn{};
    const TempDir dir;
    PtyDevice at_a{dir / "a"}, at_b{dir / "b"};
    std::unique_ptr<Relay> relays[2];
    std::unique_ptr<RunningGateway> a, b;
};

TEST_P(JoinedGateways, every_broadcast_arrives_once_and_nothing_circulates) {
    constexpr int count = 40;
    const auto from_a = [](int n) { return numbered(0xDC, 0xFF, 0x20, n); };
    const auto from_b = [](int n) { return numbered(0xDD, 0xFF, 0x20, n); };
    for (const std::string group : {"", "vehicle"}) {
        SCOPED_TRACE(group);
        Seen seen = undisturbed([&] {
            Seen run;
            start(group);
            if (HasFatalFailure()) return run;
            const std::size_t before = relays[0]->carried() + relays[1]->carried();
            for (int n = 0; n < count; ++n) {
                at_a.write(from_a(n));
                at_b.write(from_b(n));
                for (int i = 0; i < 5; ++i) turn();
            }
            run.came = run.came && until_heard(at_b, run.at_b, 0, count, from_a);
            run.came = run.came && until_heard(at_a, run.at_a, 0, count, from_b);
            run.came = run.came && until_quiet();
            add(run.at_a, heard(at_a));
            add(run.at_b, heard(at_b));
            run.carried = relays[0]->carried() + relays[1]->carried() - before;
            run.adds_up = adds_up();
            return run;
        });
        if (HasFatalFailure()) return;
        if (seen.disturbed) GTEST_SKIP() << held_up;
        EXPECT_TRUE(seen.came) << "some did not come, or something goes round";
        for (int n = 0; n < count; ++n) {
            EXPECT_EQ(seen.at_b[key(from_a(n))], 1) << n;
            EXPECT_EQ(seen.at_a[key(from_b(n))], 1) << n;
        }
        seen.at_a.erase(key(frame(0xFE, 0xDC, 0xE0, {0, 0, 0})));    // the ring may look like a device that moved: it is asked
        for (int n = 0; n < count; ++n) seen.at_a.erase(key(from_b(n)));
        EXPECT_EQ(in_hex(seen.at_a), "") << "a device does not hear itself";
        EXPECT_LE(seen.carried, 2u * 4 * count);
        EXPECT_TRUE(seen.adds_up);
    }
}

// The ring is recognised by frames of devices; the hint names the links.
TEST_P(JoinedGateways, a_broadcast_command_of_a_host_arrives_once) {
    start("");
    if (HasFatalFailure()) return;
    constexpr int count = 20;
    const auto command = [](int n) { return numbered(0xFE, 0xFF, 0xC0, n); };
    for (int n = 0; n < count; ++n) {
        at_a.write(command(n));
        for (int i = 0; i < 5; ++i) turn();
    }
    Times got;
    EXPECT_TRUE(until_heard(at_b, got, 0, count, command));
    ASSERT_TRUE(until_quiet()) << "something goes round";
    add(got, heard(at_b));
    for (int n = 0; n < count; ++n) EXPECT_EQ(got[key(command(n))], 1) << n;
    for (auto& gateway : {a.get(), b.get()})
        for (const char* way : {"way1", "way2"}) {
            const std::string hint = gateway->link(way).at("hint");
            EXPECT_TRUE(hint == "loop: frames sent to way1 come back from way2" ||
                        hint == "loop: frames sent to way2 come back from way1")
                << hint;
        }
    EXPECT_TRUE(adds_up());
}

TEST_P(JoinedGateways, a_command_over_a_group_arrives_exactly_once) {
    constexpr int count = 60;
    const auto command = [](int n) { return numbered(0xFE, 0xDD, 0xC0, n); };
    Seen seen = undisturbed([&] {
        Seen run;
        start("vehicle");
        if (HasFatalFailure()) return run;
        for (int n = 0; n < count; ++n) {
            at_b.write(numbered(0xDD, 0xFE, 0x03, n));    // the vehicle sends all the time
            at_a.write(command(n));
            for (int i = 0; i < 5; ++i) turn();
        }
        run.came = run.came && until_heard(at_b, run.at_b, 0, count, command);
        run.came = run.came && until_quiet();
        add(run.at_b, heard(at_b));
        run.adds_up = adds_up();
        return run;
    });
    if (seen.disturbed) GTEST_SKIP() << held_up;
    EXPECT_TRUE(seen.came) << "some did not come, or something goes round";
    for (int n = 0; n < count; ++n) EXPECT_EQ(seen.at_b[key(command(n))], 1) << n;
    EXPECT_TRUE(seen.adds_up);
}

// The link in use falls silent: frames on their way are lost, and those sent until the silence is noticed; no frame arrives
// twice.
TEST_P(JoinedGateways, the_other_link_of_a_group_takes_over_when_one_becomes_silent) {
    const auto command = [](int n) { return numbered(0xFE, 0xDD, 0xC0, n); };
    for (std::size_t failing : {0u, 1u}) {
        SCOPED_TRACE(failing);
        Seen seen = undisturbed([&] {
            Seen run;
            start("vehicle");
            if (HasFatalFailure()) return run;
            int n = 0;
            const auto send = [&] {
                at_b.write(numbered(0xDD, 0xFE, 0x03, n));
                at_a.write(command(n));
                ++n;
                for (int i = 0; i < 5; ++i) turn();
                heard(at_a);
            };
            while (n < 30) send();
            run.came = run.came && until_heard(at_b, run.at_b, 0, n, command);
            run.came = run.came && until_quiet();
            relays[failing]->fail();
            const int failed_at = n;
            EXPECT_TRUE(until([&] {
                send();
                add(run.at_b, heard(at_b));
                for (run.first = failed_at; run.first < n && run.at_b.count(key(command(run.first))) == 0;) ++run.first;
                return run.first < n;
            })) << "nothing arrives any more";
            run.end = n + 30;
            while (n < run.end) send();
            run.came = run.came && until_heard(at_b, run.at_b, run.first, run.end, command);
            run.came = run.came && until_quiet();
            add(run.at_b, heard(at_b));
            run.adds_up = adds_up();
            return run;
        });
        if (HasFatalFailure()) return;
        if (seen.disturbed) GTEST_SKIP() << held_up;
        EXPECT_TRUE(seen.came) << "some did not come, or something goes round";
        for (const auto& [bytes, times] : seen.at_b) EXPECT_EQ(times, 1);
        for (int i = seen.first; i < seen.end; ++i) EXPECT_EQ(seen.at_b[key(command(i))], 1) << i;
        EXPECT_TRUE(seen.adds_up);
    }
}

std::string name_of(const testing::TestParamInfo<Delays>& info) {
    const auto ms = [](Duration d) { return std::to_string(d / 1ms); };
    const Delays& d = info.param;
    return ms(d.first_there) + '_' + ms(d.first_back) + "_and_" + ms(d.second_there) + '_' + ms(d.second_back);
}

// All combinations of the delays of both links in both directions would be 81: these are the ones that differ most.
INSTANTIATE_TEST_SUITE_P(Delays, JoinedGateways,
                         testing::Values(Delays{0ms, 0ms, 0ms, 0ms}, Delays{60ms, 60ms, 60ms, 60ms},
                                         Delays{500ms, 500ms, 500ms, 500ms}, Delays{0ms, 0ms, 500ms, 500ms},
                                         Delays{60ms, 500ms, 0ms, 0ms}, Delays{500ms, 0ms, 0ms, 500ms},
                                         Delays{0ms, 60ms, 60ms, 500ms}, Delays{500ms, 60ms, 60ms, 0ms}),
                         name_of);

}    // namespace
}    // namespace two_gateways_tests
