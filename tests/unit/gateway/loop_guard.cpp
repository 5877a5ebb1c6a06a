#include <gateway/loop_guard.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace loop_guard_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;
using Fate = LoopGuard::Fate;

namespace {

constexpr TimePoint start{1h};
constexpr LinkId link(unsigned n) { return static_cast<LinkId>(n); }
constexpr ChannelId channel(unsigned n) { return static_cast<ChannelId>(n); }
ChannelSet channels(std::initializer_list<unsigned> all) {
    ChannelSet set;
    for (const unsigned n : all) set.insert(channel(n));
    return set;
}

constexpr Said device(std::uint64_t key) { return {key, false}; }
constexpr Said host(std::uint64_t key) { return {key, true}; }

class Guarded : public testing::Test {
protected:
    Guarded() {
        for (unsigned n = 0; n < 8; ++n) guard.open(channel(n), link(n), 0, true, TimePoint::min());      // may be probed
        for (unsigned n = 8; n < 16; ++n) guard.open(channel(n), link(n), 0, false, TimePoint::min());    // may not
    }
    Fate fate(const Said& said, unsigned from, TimePoint now) { return guard.judge(said, channel(from), now).fate; }
    /// As the gateway does: what passes goes to `to`.
    Fate pass(const Said& said, unsigned from, ChannelSet to, TimePoint now) {
        const auto judgement = guard.judge(said, channel(from), now);
        if (judgement.probe) probe = bytes_of(guard.rings().ask(channel(from), now));
        if (judgement.fate == Fate::passes) guard.remember(said, channel(from), to, now);
        return judgement.fate;
    }
    static support::Bytes bytes_of(ano::FrameView frame) { return {frame.bytes().begin(), frame.bytes().end()}; }
    void come_back(unsigned from, TimePoint now) {
        EXPECT_EQ(guard.rings().take(ano::FrameView{probe}, channel(from), now), RingWatch::Probe::ours);
    }

    LoopGuard guard{7};
    support::Bytes probe;    // the last that left
};

TEST(Said, hosts_may_say_what_others_say) {
    const auto said = [](std::uint8_t source, std::uint8_t id) {
        return said_by(ano::FrameView{support::frame(source, 0xFF, id, {0, 0, 0})});
    };
    EXPECT_TRUE(said(0xFE, 0xE0).by_host && said(0xD2, 0xC0).by_host);
    EXPECT_FALSE(said(0xDC, 0xE0).by_host);
}

TEST_F(Guarded, knows_what_a_device_said_when_it_comes_back) {
    guard.remember(device(1), channel(5), channels({3, 4}), start);
    EXPECT_EQ(fate(device(1), 3, start + 1s), Fate::ends);
    EXPECT_EQ(fate(device(1), 3, start + 1s), Fate::ends) << "every time";
    EXPECT_EQ(fate(device(1), 4, start + 1999ms), Fate::ends);
    EXPECT_EQ(fate(device(1), 6, start + 1s), Fate::ends) << "a copy, whichever way it took";
    EXPECT_EQ(fate(device(1), 5, start + 1s), Fate::passes) << "its sender may repeat it";
    EXPECT_EQ(fate(device(2), 3, start + 1s), Fate::passes);
    EXPECT_EQ(fate(device(1), 3, start + 2s), Fate::passes);
}

TEST_F(Guarded, a_channel_that_takes_over_a_number_starts_fresh) {
    guard.remember(device(1), channel(5), channel(3), start);
    guard.open(channel(3), link(3), 0, true, start);    // in one batch with the frame
    EXPECT_EQ(fate(device(1), 3, start), Fate::passes);
    guard.remember(device(1), channel(5), channel(3), start + 1s);
    EXPECT_EQ(fate(device(1), 3, start + 1s), Fate::ends);
}

TEST_F(Guarded, a_channel_that_takes_over_a_number_has_lost_nothing) {
    auto now = start;
    while (pass(device(1), 0, channel(3), now) == Fate::passes) now += 500ms;
    guard.open(channel(0), link(0), 0, true, now);
    EXPECT_EQ(guard.take_lost(channel(0), now + 10s), 0u);
}

TEST_F(Guarded, a_sender_with_a_new_port_goes_on_saying_the_same) {
    guard.remember(device(1), channel(0), channel(1), start + 1s);
    guard.open(channel(20), link(0), 0, true, start + 2s);
    for (auto now = start + 2s; now < start + 4s; now += 10ms) {
        EXPECT_EQ(pass(device(1), 20, channel(1), now), Fate::passes);
        EXPECT_EQ(fate(device(1), 1, now), Fate::ends) << "it went there";
    }
}

// A thief said it first, twice, and from a new port once more.
TEST_F(Guarded, what_was_said_in_a_devices_name_takes_no_more_of_it_than_that) {
    const auto at = [&](unsigned from, TimePoint now, Speaks speaks) {
        Said said = device(1);
        said.speaks = speaks;
        const auto fate = guard.judge(said, channel(from), now).fate;
        if (fate == Fate::passes) guard.remember(said, channel(from), channels({0, 1, 2}) - channel(from), now);
        return fate;
    };
    EXPECT_EQ(at(1, start, Speaks::elsewhere), Fate::passes);
    EXPECT_EQ(at(1, start + 1ms, Speaks::elsewhere), Fate::passes);
    EXPECT_EQ(at(0, start + 10ms, Speaks::at_home), Fate::ends);
    EXPECT_EQ(at(0, start + 20ms, Speaks::at_home), Fate::ends);
    for (int n = 3; n < 100; ++n) EXPECT_EQ(at(0, start + n * 10ms, Speaks::at_home), Fate::passes);
    EXPECT_EQ(at(1, start + 1s, Speaks::elsewhere), Fate::ends) << "the first to say it is the device again";
    EXPECT_EQ(at(2, start + 1s, Speaks::at_home), Fate::ends) << "a copy, if it is at home there as well";
    guard.open(channel(20), link(1), 0, true, start + 1s);
    EXPECT_EQ(at(20, start + 1001ms, Speaks::elsewhere), Fate::passes);
    EXPECT_EQ(at(0, start + 1002ms, Speaks::at_home), Fate::passes);
}

TEST_F(Guarded, links_of_one_group_are_no_ways_round) {
    guard.open(channel(20), link(20), 3, true, start);
    guard.open(channel(21), link(21), 3, true, start);
    guard.remember(device(1), channel(20), channel(1), start + 1s);
    EXPECT_EQ(fate(device(1), 21, start + 1s), Fate::passes) << "DuplicateGuard's";
}

TEST_F(Guarded, another_host_says_the_same_as_often_as_it_likes) {
    EXPECT_EQ(pass(host(1), 0, channels({1, 2}), start), Fate::passes);
    for (auto now = start + 700ms; now < start + 15s; now += 700ms)
        EXPECT_EQ(pass(host(1), 1, channels({0, 2}), now), Fate::passes);
}

TEST_F(Guarded, two_pass_until_the_verdict) {
    EXPECT_EQ(pass(host(1), 0, channels({1, 2}), start), Fate::passes);
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 10ms), Fate::passes);
    ASSERT_FALSE(probe.empty()) << "the question leaves ahead of it";
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 20ms), Fate::waits);
    EXPECT_EQ(pass(host(1), 0, channels({1, 2}), start + 20ms), Fate::waits);
    EXPECT_EQ(pass(host(2), 0, channels({1, 2}), start + 20ms), Fate::passes) << "another";
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 10ms + RingWatch::patience), Fate::passes) << "no answer: no ring";
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 11ms + RingWatch::patience), Fate::waits) << "not by hand";
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 120ms + RingWatch::patience), Fate::passes);
    EXPECT_EQ(pass(host(1), 0, channels({1, 2}), start + 2s), Fate::passes);
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 2100ms), Fate::passes) << "by now any ring has answered";
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 2101ms), Fate::passes);
}

TEST_F(Guarded, a_ring_is_known_by_its_answer) {
    pass(host(1), 0, channels({1, 2}), start);
    pass(host(1), 1, channels({0, 2}), start + 10ms);
    come_back(2, start + 20ms);
    for (const unsigned from : {1u, 2u}) EXPECT_EQ(pass(host(1), from, channels({0, 1, 2}), start + 20ms), Fate::ends);
    EXPECT_EQ(pass(host(1), 0, channels({1, 2}), start + 20ms + RingWatch::patience), Fate::passes) << "it is not there";
    EXPECT_EQ(pass(host(2), 0, channels({1, 2}), start + 30s), Fate::passes);
    EXPECT_EQ(pass(host(2), 1, channels({0, 2}), start + 30s), Fate::ends) << "at once";
    come_back(2, start + 30s);    // it was asked again
    EXPECT_TRUE(guard.rings().is_ring(channel(1), start + 89s));
    EXPECT_FALSE(guard.rings().is_ring(channel(1), start + 91s));
}

// It comes by the channel that brought it first, and goes round in one direction.
TEST_F(Guarded, what_entered_a_known_ring_elsewhere_passes_once) {
    pass(host(9), 0, channels({1, 2}), start);
    pass(host(9), 1, channels({0, 2}), start);
    come_back(2, start);
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 1s), Fate::passes);
    EXPECT_EQ(pass(host(1), 2, channels({0, 1}), start + 1s), Fate::ends);
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 1s), Fate::ends) << "went out by 2";
    EXPECT_EQ(pass(host(1), 1, channels({0, 2}), start + 2s), Fate::passes) << "said again";
}

TEST_F(Guarded, where_no_probe_may_go_one_return_passes) {
    pass(host(1), 0, channels({8, 9}), start);
    EXPECT_EQ(pass(host(1), 8, channels({0, 9}), start + 10ms), Fate::passes);
    EXPECT_EQ(pass(host(1), 9, channels({0, 8}), start + 10ms), Fate::ends);
    EXPECT_EQ(pass(host(1), 8, channels({0, 9}), start + 20ms), Fate::ends);
    EXPECT_TRUE(probe.empty());
}

TEST_F(Guarded, where_no_probe_may_go_an_end_that_keeps_what_it_gets_is_no_ring) {
    pass(host(1), 0, channels({8}), start);    // and it never came back
    pass(host(2), 0, channels({8}), start + 5s);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(pass(host(2), 8, channels({0}), start + 5s + i * 100ms), Fate::passes);
}

TEST_F(Guarded, where_no_probe_may_go_one_that_comes_back_often_counts_once) {
    for (const unsigned key : {1u, 2u, 3u, 4u}) pass(host(key), 0, channels({8}), start);
    for (int n = 0; n < 3; ++n) fate(host(1), 8, start + 10ms);
    EXPECT_TRUE(guard.rings().is_clear(channel(8), start + 3s)) << "one of four came back";
}

TEST_F(Guarded, where_no_probe_may_go_what_a_device_said_tells_of_a_ring) {
    guard.remember(device(1), channel(0), channels({8}), start);
    EXPECT_EQ(fate(device(1), 8, start + 100ms), Fate::ends);
    pass(host(2), 0, channels({8}), start + 1s);
    EXPECT_EQ(fate(host(2), 8, start + 1s), Fate::ends);
    pass(host(2), 0, channels({8}), start + 70s);
    EXPECT_EQ(fate(host(2), 8, start + 70s), Fate::passes) << "not for ever";
}

// In a socket, while the loop stood still.
TEST_F(Guarded, a_copy_that_waited_to_be_read_is_one_all_the_same) {
    EXPECT_EQ(pass(device(1), 0, channels({1, 2}), start), Fate::passes);
    Said copy = device(1);
    copy.arrived = start + 1s;
    EXPECT_EQ(fate(copy, 1, start + 4s), Fate::ends);
    copy.arrived = start + 2s;
    EXPECT_EQ(fate(copy, 1, start + 4s), Fate::passes);
}

TEST_F(Guarded, a_sender_that_repeats_itself_loses_nothing) {
    std::uint32_t passed = 0;
    auto now = start;
    for (int i = 0; i < 10'000; ++i, now += 10ms) {
        const auto judgement = guard.judge(device(1), channel(0), now);
        if (judgement.fate != Fate::passes) continue;
        passed += judgement.copies;
        guard.remember(device(1), channel(0), channel(3), now);
    }
    EXPECT_EQ(passed, 10'000u);
    EXPECT_EQ(guard.take_lost(channel(0), now + 10s), 0u);
}

TEST_F(Guarded, what_entered_by_the_ring_itself_passes_twice) {
    const Said lock = host(1);
    EXPECT_EQ(pass(lock, 0, channels({1, 2}), TimePoint{1h}), Fate::passes);
    EXPECT_TRUE(probe.empty());
    EXPECT_EQ(pass(lock, 0, channels({1, 2}), TimePoint{1h} + 1ms), Fate::passes) << "a sender that repeats itself, or a ring";
    ASSERT_FALSE(probe.empty());
    come_back(1, TimePoint{1h} + 2ms);
    for (int n = 0; n < 10; ++n) EXPECT_EQ(pass(lock, 0, channels({1, 2}), TimePoint{1h} + 3ms + n * 1ms), Fate::ends) << n;
}

TEST_F(Guarded, a_device_that_seems_to_repeat_itself_faster_than_any_is_asked_about) {
    const Said telemetry = device(1);
    TimePoint now{1h};
    for (int n = 0; n < 100; ++n, now += 10ms) EXPECT_EQ(pass(telemetry, 0, channels({1, 2}), now), Fate::passes) << n;
    EXPECT_TRUE(probe.empty()) << "a sensor at rest";
    int passed = 0;
    for (; probe.empty() && passed < 1000; ++passed, now += 1ms) pass(telemetry, 0, channels({1, 2}), now);
    EXPECT_LE(passed, 64);
    come_back(1, now);
    EXPECT_EQ(pass(telemetry, 0, channels({1, 2}), now + 1ms), Fate::ends);
    EXPECT_EQ(pass(telemetry, 0, channels({1, 2}), now + 20ms), Fate::passes) << "the device itself, again";
}

// Until a probe may be answered, what comes back is a copy; behind that, and where none may go, a device on two links as well.
TEST_F(Guarded, what_comes_back_without_a_ring_may_be_of_a_device_on_two_links) {
    const auto brought_back = [&](unsigned by, TimePoint now) {
        guard.remember(device(1), channel(0), channels({1, 8}), now);
        const auto judgement = guard.judge(device(1), channel(by), now + 1ms);
        EXPECT_EQ(judgement.fate, Fate::ends);
        if (judgement.probe) guard.rings().ask(channel(by), now + 1ms);
        return judgement.elsewhere;
    };
    EXPECT_FALSE(brought_back(1, start));
    EXPECT_TRUE(brought_back(1, start + 1ms + RingWatch::patience));
    EXPECT_TRUE(brought_back(8, start + 10s)) << "it may not be probed";
}

// Two hosts whose sticks rest: what waited for longer would be dropped behind it.
TEST_F(Guarded, a_state_waits_for_less_than_it_may_be_old) {
    Said sticks = host(1);
    sticks.state = true;
    guard.remember(sticks, channel(0), channels({1, 2}), TimePoint{1h});
    int waited = 0;
    for (unsigned n = 0; n < 3; ++n) {
        const auto judgement = guard.judge(sticks, channel(1), TimePoint{1h} + 1ms);
        if (judgement.probe) guard.rings().ask(channel(1), TimePoint{1h} + 1ms);
        if (judgement.fate != Fate::waits) continue;
        ++waited;
        EXPECT_LT(judgement.wait, AgeLimits{}.control);
    }
    EXPECT_GT(waited, 0);
}

// Sticks at rest for hours: whoever listens to them must not take their sender for lost.
TEST_F(Guarded, sticks_that_rest_are_never_withheld_for_long) {
    Said sticks = host(1);
    sticks.state = true;
    TimePoint now{1h}, left = now;
    std::uint32_t came = 0, went = 0;
    for (std::uint32_t n = 0; n < 300'000; ++n, now += 20ms) {
        const auto judgement = guard.judge(sticks, channel(0), now);
        ++came;
        if (judgement.fate != Fate::passes) continue;
        guard.remember(sticks, channel(0), channels({1, 2}), now);
        went += judgement.copies;
        ASSERT_LE(now - left, LoopGuard::max_state_withheld + 20ms) << n;
        left = now;
    }
    EXPECT_LE(came - went, 6u) << "none is lost";
}

// A second host moves its sticks like the first: neither waits for the answer of the probe.
TEST_F(Guarded, sticks_of_a_second_host_do_not_wait) {
    Said sticks = host(1);
    sticks.state = true;
    for (int n = 0; n < 100; ++n) {
        EXPECT_EQ(pass(sticks, 0, channels({1, 2}), TimePoint{1h} + n * 20ms), Fate::passes) << n;
        EXPECT_EQ(pass(sticks, 1, channels({0, 2}), TimePoint{1h} + n * 20ms + 8ms), Fate::passes) << n;
    }
}

TEST_F(Guarded, a_ring_that_began_elsewhere_ends_and_its_last_is_counted) {
    auto now = start;
    int turns = 0;
    for (; turns < 100'000 && pass(device(1), 0, channel(3), now) == Fate::passes; now += 500ms) ++turns;
    EXPECT_EQ(turns, 1000);
    EXPECT_EQ(guard.take_lost(channel(0), now), 0u) << "the next may still come";
    EXPECT_EQ(guard.take_lost(channel(0), now + 2s), 1u);
    EXPECT_EQ(guard.take_lost(channel(0), now + 2s), 0u);
}

// A command that goes round by channel 0, `way(late)` long after it was sent late so often; how often it was until it ends.
class RoundTrips : public Guarded {
protected:
    template <class Way>
    int late_starts(Way way, int turns = 200) {
        Said lock = host(1);
        lock.command = true;
        int late = 0;
        auto now = start;
        for (int turn = 0; turn < turns; ++turn, now += way(late)) {
            const auto judgement = guard.judge(lock, channel(0), now);
            if (judgement.fate == Fate::ends) break;
            Said waited = lock;
            if (judgement.fate == Fate::waits) {
                now += judgement.wait;
                waited.waited = true;
                EXPECT_EQ(fate(waited, 0, now), Fate::passes);
                ++late;
            }
            guard.remember(waited, channel(0), channel(3), now);
        }
        return late;
    }
};

TEST_F(RoundTrips, as_soon_as_ever_after_three_late_starts_end) {
    EXPECT_EQ(late_starts([](int) { return 200ms; }), LoopGuard::enough);
}

TEST_F(RoundTrips, that_once_took_another_time_are_counted_anew) {
    EXPECT_EQ(late_starts([](int late) { return late < 2 ? 200ms : 500ms; }), 2 + LoopGuard::enough);
}

TEST_F(RoundTrips, that_twice_took_another_time_are_a_senders) {
    EXPECT_EQ(late_starts([](int late) { return late == 1 ? 500ms : 200ms; }, 100), 2);
}

TEST_F(Guarded, a_sender_that_says_it_again_meanwhile_need_not_wait_any_more) {
    Said lock = host(1);
    lock.command = true;
    auto now = start;
    for (; fate(lock, 0, now) != Fate::waits; now += 200ms) guard.remember(lock, channel(0), channel(3), now);
    Said hurried = lock;
    hurried.waited = hurried.hurried = true;
    now += 200ms;
    ASSERT_EQ(pass(hurried, 0, channel(3), now), Fate::passes);
    EXPECT_EQ(pass(lock, 0, channel(3), now), Fate::passes) << "the one that came meanwhile";
    EXPECT_EQ(pass(lock, 0, channel(3), now + 200ms), Fate::passes);
}

// Its sender says it now sooner, now later.
TEST_F(Guarded, a_command_that_waited_is_one_repeat) {
    Said lock = host(1), hurried = lock;
    lock.command = hurried.command = true;
    hurried.waited = hurried.hurried = true;
    auto now = start;
    std::uint32_t said = 0, waited = 0;
    for (; said < 2 * LoopGuard::repeats; ++said, now += said % 2 ? 10ms : 300ms) {
        const Fate fate = pass(lock, 0, channel(3), now);
        if (fate == Fate::withheld) break;
        if (fate != Fate::waits) continue;
        ++waited;
        EXPECT_EQ(pass(hurried, 0, channel(3), now), Fate::passes);
    }
    EXPECT_GT(waited, 0u);
    EXPECT_EQ(said, LoopGuard::repeats) << "behind the first";
}

TEST_F(Guarded, a_thousand_in_a_second_are_a_ring_whatever_the_probe_said) {
    pass(host(1), 0, channels({1}), start);
    pass(host(1), 1, channels({0}), start);
    std::uint32_t passed = 0;
    for (auto now = start + 500ms; now < start + 1500ms; now += 100us)
        passed += pass(host(1), 1, channels({0}), now) == Fate::passes;
    EXPECT_LE(passed, RingWatch::storm);
    EXPECT_TRUE(guard.rings().is_ring(channel(1), start + 2s));
}

TEST_F(Guarded, a_link_that_is_removed_leaves_nothing_to_the_next_of_its_number) {
    guard.remember(device(1), channel(5), channels({3, 4}), start);
    guard.remember(device(2), channel(4), channels({3, 5}), start);
    guard.close(channel(5));
    guard.remove_link(link(5));
    EXPECT_EQ(fate(device(1), 3, start + 1ms), Fate::passes) << "nobody knows who said it";
    EXPECT_EQ(fate(device(2), 3, start + 1ms), Fate::ends) << "another's is known still";
    guard.open(channel(6), link(5), 0, true, start);
    guard.remember(device(3), channel(6), channel(4), start + 1ms);
    EXPECT_EQ(fate(device(3), 5, start + 2ms), Fate::ends) << "the channel that is gone is at no link";
}

TEST_F(Guarded, a_ring_ends_with_a_link_that_it_is_made_of) {
    pass(host(1), 0, channels({1, 2}), start);
    pass(host(1), 1, channels({0, 2}), start + 10ms);
    come_back(2, start + 20ms);
    ASSERT_TRUE(guard.rings().ring(channel(1), start + 20ms));
    guard.close(channel(2));
    guard.remove_link(link(2));
    EXPECT_FALSE(guard.rings().ring(channel(1), start + 20ms));
    EXPECT_FALSE(guard.rings().is_ring(channel(1), start + 20ms));
    guard.open(channel(2), link(2), 0, true, start + 30ms);
    EXPECT_FALSE(guard.rings().is_ring(channel(2), start + 30ms));
}

}    // namespace
}    // namespace loop_guard_tests
