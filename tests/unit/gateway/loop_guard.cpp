#include <gateway/loop_guard.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace loop_guard_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;
using support::Bytes;

namespace {

constexpr TimePoint start{1h};
constexpr LinkId link(unsigned n) { return static_cast<LinkId>(n); }
constexpr ChannelId channel(unsigned n) { return static_cast<ChannelId>(n); }
ChannelSet channels(std::initializer_list<unsigned> all) {
    ChannelSet set;
    for (const unsigned n : all) set.insert(channel(n));
    return set;
}
Bytes bytes_of(ano::FrameView frame) { return {frame.bytes().begin(), frame.bytes().end()}; }

class Guarded : public testing::Test {
protected:
    Guarded() {
        for (unsigned n = 0; n < 8; ++n) guard.open(channel(n), link(n), 0, true, TimePoint::min());
        for (unsigned n = 8; n < 16; ++n) guard.open(channel(n), link(n), 0, false, TimePoint::min());    // without probes
    }
    LoopGuard::Judgement judge(std::uint64_t key, unsigned from, TimePoint now) {
        return guard.judge({key, channel(from), now}, now);
    }
    /// Like the Forwarder: a passed frame is sent to `to`. True: it passed.
    bool pass(std::uint64_t key, unsigned from, ChannelSet to, TimePoint now, bool at_home = false) {
        const LoopGuard::Arrival arrival{key, channel(from), now, at_home};
        const auto judgement = guard.judge(arrival, now);
        if (!judgement.looped) guard.remember(arrival, to, now);
        return !judgement.looped;
    }
    void ask_and_answer(unsigned out, unsigned back, TimePoint asked, TimePoint answered) {
        const Bytes probe = bytes_of(guard.ask(channel(out), asked));
        EXPECT_FALSE(guard.accept_probe(ano::FrameView{probe}, channel(back), answered)) << "it goes no further";
    }
    bool is_known(unsigned n, TimePoint now) { return guard.loop(channel(n), now).has_value(); }

    LoopGuard guard{7};
};

TEST_F(Guarded, a_copy_passes_after_probes_and_teaches_nothing_until_they_can_have_returned) {
    pass(1, 5, channels({3, 4}), start);
    const auto copy = judge(1, 3, start + 10ms);
    EXPECT_TRUE(copy.suspect && copy.undecided && !copy.looped);
    EXPECT_EQ(copy.ask, channels({3}));
    EXPECT_FALSE(judge(2, 3, start + 10ms).suspect) << "another frame";
    guard.ask(channel(3), start + 10ms);
    EXPECT_TRUE(judge(1, 3, start + 1900ms).undecided);
    pass(1, 5, channels({3, 4}), start + 2s);
    EXPECT_FALSE(judge(1, 3, start + 2010ms).undecided) << "no loop is as slow";
    EXPECT_FALSE(judge(1, 9, start + 2010ms).undecided) << "by which no probe leaves";
}

// On channels without probes, and too rarely for a storm.
TEST_F(Guarded, a_circulating_command_is_dropped_and_telemetry_is_not) {
    const auto rounds = [&](std::uint64_t key, bool acts) {
        int passed = 0;
        for (int i = 0; i < 500; ++i) {
            const TimePoint now = start + i * 100ms;
            const LoopGuard::Arrival arrival{key, channel(i == 0 ? 8 : 9), now, false, acts};
            if (guard.judge(arrival, now).looped) break;    // of a loop: no further copies arrive
            guard.remember(arrival, channels({3, 10}), now);
            ++passed;
        }
        return passed;
    };
    EXPECT_EQ(rounds(1, false), 500);
    EXPECT_EQ(rounds(2, true), 1 + LoopGuard::max_again);
}

TEST_F(Guarded, the_first_sender_of_a_command_may_repeat_it_any_number_of_times) {
    for (int i = 0; i < 500; ++i) {
        const TimePoint now = start + i * 100ms;
        const LoopGuard::Arrival arrival{1, channel(8), now, false, true};
        ASSERT_FALSE(guard.judge(arrival, now).looped);
        guard.remember(arrival, channels({3, 10}), now);
    }
}

TEST_F(Guarded, only_copies_of_frames_sent_into_a_known_loop_are_dropped) {
    pass(1, 5, channels({3, 4}), start);
    pass(1, 3, channels({4, 5}), start + 10ms);
    ask_and_answer(3, 4, start + 10ms, start + 20ms);
    for (const unsigned from : {3u, 4u}) {
        const auto copy = judge(1, from, start + 30ms);
        EXPECT_TRUE(copy.looped);
        EXPECT_EQ(copy.ask, channels({3})) << "to find out whether it is still there";
    }
    EXPECT_TRUE(pass(2, 5, channels({6}), start + 1s));
    EXPECT_TRUE(pass(2, 4, channels({5, 6}), start + 1s)) << "another board's: it was not sent there";
    EXPECT_TRUE(pass(1, 5, channels({3, 4}), start + 1100ms)) << "its sender's";
    EXPECT_EQ(guard.loop(channel(4), start + 1s), (LoopGuard::Loop{link(3), link(4)}));
}

TEST_F(Guarded, a_frame_that_entered_a_known_loop_elsewhere_passes_once_each_time_it_is_sent) {
    ask_and_answer(1, 2, start, start);
    EXPECT_TRUE(pass(1, 1, channels({0, 2}), start + 1s));
    EXPECT_FALSE(pass(1, 1, channels({0, 2}), start + 1s)) << "it left by 2 and came back";
    EXPECT_TRUE(pass(1, 1, channels({0, 2}), start + 1100ms)) << "sent again";
    EXPECT_FALSE(pass(1, 2, channels({0, 1}), start + 1100ms)) << "the other way round, where it met the one that left by 2";
    EXPECT_TRUE(pass(1, 1, channels({0, 2}), start + 1200ms)) << "so that this is its sender's";
}

TEST_F(Guarded, a_frame_sent_before_the_loop_was_known_is_also_dropped_when_it_returns) {
    pass(1, 1, channels({0, 2}), start);
    ask_and_answer(2, 1, start, start + 10ms);
    EXPECT_FALSE(pass(1, 1, channels({0, 2}), start + 20ms));
    EXPECT_TRUE(pass(1, 1, channels({0, 2}), start + 30ms));
}

TEST_F(Guarded, a_loop_ends_when_its_probes_do_not_return_or_after_a_minute) {
    ask_and_answer(1, 2, start, start + 10ms);
    EXPECT_TRUE(is_known(1, start + 60s) && is_known(2, start + 60s));
    EXPECT_FALSE(is_known(1, start + 61s) || guard.is_loop(channel(2), start + 61s));
    ask_and_answer(1, 2, start + 70s, start + 70s);
    guard.ask(channel(1), start + 80s);
    guard.ask(channel(1), start + 84s);
    EXPECT_TRUE(is_known(2, start + 84900ms));
    EXPECT_FALSE(is_known(2, start + 85s));
}

TEST_F(Guarded, old_and_forged_probes_are_ignored) {
    const Bytes old = bytes_of(guard.ask(channel(1), start));
    for (int i = 1; i <= 8; ++i) guard.ask(channel(1), start + i * 1s);
    EXPECT_FALSE(guard.accept_probe(ano::FrameView{old}, channel(2), start + 9s));
    EXPECT_FALSE(is_known(1, start + 9s));
    const Bytes asked = bytes_of(guard.ask(channel(1), start + 9s));
    auto data = Bytes(asked.begin() + 6, asked.end() - 2);
    data[16] = 3;    // of another channel
    const Bytes forged = support::frame(0xFE, 0xFF, probe_id, data);
    EXPECT_FALSE(guard.accept_probe(ano::FrameView{forged}, channel(2), start + 9s));
    EXPECT_FALSE(is_known(1, start + 9s) || is_known(2, start + 9s));
    const Bytes first = bytes_of(guard.ask(channel(4), start));
    guard.ask(channel(4), start + 1s);
    guard.accept_probe(ano::FrameView{first}, channel(5), start + 1500ms);
    EXPECT_TRUE(is_known(5, start + 2s)) << "though the next one has left";
}

TEST_F(Guarded, the_probe_is_a_frame_that_every_bridge_forwards) {
    const Bytes probe = bytes_of(guard.ask(channel(1), start));
    ASSERT_TRUE(ano::frame_at(probe));
    EXPECT_TRUE(is_probe(ano::FrameView{probe}));
    EXPECT_EQ((std::array{probe[1], probe[2], probe[3]}), (std::array<std::uint8_t, 3>{0xFE, 0xFF, 0xFB}));
    EXPECT_NE(bytes_of(guard.ask(channel(1), start)), probe);
    EXPECT_FALSE(is_probe(ano::FrameView{support::frame(0xFE, 0xFF, 0xFB, {1, 2, 3})})) << "somebody's own 0xFB";
    auto data = Bytes(probe.begin() + 6, probe.end() - 2);
    EXPECT_FALSE(is_probe(ano::FrameView{support::frame(0xDC, 0xFF, 0xFB, data)}));
    data[0] = 'X';
    EXPECT_FALSE(is_probe(ano::FrameView{support::frame(0xFE, 0xFF, 0xFB, data)}));
}

TEST_F(Guarded, a_probe_of_another_gateway_is_forwarded_once) {
    LoopGuard other{8};
    other.open(channel(0), link(0), 0, true, start);
    const Bytes probe = bytes_of(other.ask(channel(0), start));
    EXPECT_TRUE(guard.accept_probe(ano::FrameView{probe}, channel(1), start));
    EXPECT_FALSE(guard.accept_probe(ano::FrameView{probe}, channel(2), start + 1s));
    EXPECT_TRUE(guard.accept_probe(ano::FrameView{bytes_of(other.ask(channel(0), start))}, channel(1), start));
}

TEST_F(Guarded, probes_are_sent_at_most_once_a_second_and_never_on_a_cable) {
    EXPECT_TRUE(guard.is_due(channel(1), start));
    guard.ask(channel(1), start);
    EXPECT_FALSE(guard.is_due(channel(1), start + 999ms));
    EXPECT_TRUE(guard.is_due(channel(1), start + 1s));
    EXPECT_FALSE(guard.is_due(channel(8), start));
    guard.open(channel(1), link(1), 0, false, start + 1s);
    EXPECT_FALSE(guard.is_due(channel(1), start + 5s)) << "opened again as a cable";
}

TEST_F(Guarded, more_than_200_copies_in_a_second_beyond_the_originals_are_a_loop) {
    pass(1, 0, channels({8}), start);
    int passed = 0;
    for (int n = 0; n < 1000; ++n) passed += pass(1, 8, channels({0}), start + n * 1ms);
    EXPECT_EQ(passed, static_cast<int>(1 + LoopGuard::max_surplus)) << "and one that is as often as the original";
    EXPECT_EQ(guard.loop(channel(8), start + 59s), (LoopGuard::Loop{link(8), link(8)}));
    EXPECT_FALSE(is_known(0, start + 1s));
    EXPECT_FALSE(is_known(8, start + 62s)) << "not for ever";
}

// Each of them once or twice a second: their sum is counted.
TEST_F(Guarded, copies_of_different_frames_are_counted_together) {
    int passed = 0;
    for (unsigned n = 0; n < 1000; ++n) {
        const TimePoint now = start + n * 1ms;
        pass(n, 0, channels({8, 9}), now);
        for (int often = 0; often < 2; ++often) passed += pass(n, 8, channels({0, 9}), now);
    }
    EXPECT_LE(passed, static_cast<int>(3 * LoopGuard::max_surplus));
    EXPECT_TRUE(is_known(8, start + 1s));
}

TEST_F(Guarded, three_boards_that_send_the_same_frame_lose_none_at_rates_below_the_limit) {
    for (int n = 0; n < 10'000; ++n) {
        const TimePoint now = start + n * 1ms;
        if (n % 100 == 0) {
            EXPECT_TRUE(pass(1, 0, channels({1, 9, 15}), now));
        }
        if (n % 11 == 0) {
            EXPECT_TRUE(pass(1, 1, channels({0, 9, 15}), now));
        }
        if (n % 10 == 0) {
            EXPECT_TRUE(pass(1, 9, channels({0, 1, 15}), now));
        }
    }
}

TEST_F(Guarded, a_thousand_copies_in_a_second_are_a_loop_regardless_of_the_originals) {
    for (int n = 0; n < 2000; ++n) {
        pass(1, 0, channels({8}), start + n * 100us);
        pass(1, 8, channels({0}), start + n * 100us);
    }
    EXPECT_TRUE(is_known(0, start + 1s) && is_known(8, start + 1s));
}

TEST_F(Guarded, a_sender_may_repeat_a_frame_any_number_of_times) {
    for (int n = 0; n < 10'000; ++n) EXPECT_TRUE(pass(1, 0, channels({1, 8}), start + n * 100us));
    EXPECT_TRUE(judge(1, 0, start + 1s).suspect) << "but a loop may go one way";
    EXPECT_FALSE(judge(1, 0, start + 1s).looped);
}

TEST_F(Guarded, a_sender_that_is_alone_for_two_seconds_counts_as_the_original) {
    pass(1, 0, channels({1, 2}), start);
    for (auto now = start + 100ms; now < start + 2s; now += 100ms) pass(1, 1, channels({0, 2}), now);
    EXPECT_FALSE(judge(1, 1, start + 2s).suspect);
    pass(1, 1, channels({0, 2}), start + 2s);
    EXPECT_TRUE(judge(1, 0, start + 2100ms).suspect);
}

TEST_F(Guarded, a_sender_that_uses_the_address_of_a_device_causes_no_loss_of_its_frames) {
    for (int n = 0; n < 1000; ++n) {
        if (n % 500 == 0) {
            EXPECT_TRUE(pass(1, 1, channels({0, 2}), start + n * 1ms));
        }
        EXPECT_TRUE(pass(1, 0, channels({1, 2}), start + n * 1ms, true)) << n;
    }
}

TEST_F(Guarded, a_channel_that_reuses_a_number_starts_without_history) {
    guard.remember({1, channel(5), start}, channel(3), start);
    guard.open(channel(3), link(3), 0, true, start);    // in one batch with the frame
    EXPECT_FALSE(judge(1, 3, start).suspect);
    guard.remember({1, channel(5), start + 1s}, channel(3), start + 1s);
    EXPECT_TRUE(judge(1, 3, start + 1s).suspect);
    ask_and_answer(3, 4, start + 1s, start + 1s);
    guard.open(channel(4), link(4), 0, true, start + 1s);
    EXPECT_FALSE(is_known(3, start + 1s) || is_known(4, start + 1s)) << "the loop ends with one of its channels";
}

TEST_F(Guarded, frames_of_a_sender_with_a_new_port_are_not_copies) {
    guard.remember({1, channel(0), start + 1s}, channel(1), start + 1s);
    guard.open(channel(20), link(0), 0, true, start + 1s);
    EXPECT_FALSE(judge(1, 20, start + 2s).suspect);
}

TEST_F(Guarded, links_of_one_group_do_not_form_a_loop) {
    guard.open(channel(20), link(20), 3, true, start);
    guard.open(channel(21), link(21), 3, true, start);
    guard.remember({1, channel(20), start + 1s}, channel(1), start + 1s);
    EXPECT_FALSE(judge(1, 21, start + 1s).suspect) << "DuplicateGuard's";
}

TEST_F(Guarded, a_copy_that_waited_to_be_read_is_still_a_copy) {
    pass(1, 0, channels({1, 2}), start);
    EXPECT_TRUE(guard.judge({1, channel(1), start + 1s}, start + 4s).suspect);
    EXPECT_FALSE(guard.judge({1, channel(1), start + 2s}, start + 4s).suspect);
}

// It returns on any link, and is a copy on each.
TEST_F(Guarded, frames_of_the_gateway_that_return_are_copies_on_every_link) {
    guard.remember({1, ourselves, start}, channels({0, 1}), start);
    EXPECT_TRUE(judge(1, 0, start + 1s).suspect && judge(1, 1, start + 1s).suspect);
    ask_and_answer(0, 1, start + 1s, start + 1s);
    EXPECT_TRUE(judge(1, 0, start + 1s).looped && judge(1, 1, start + 1s).looped);
}

TEST_F(Guarded, a_copy_of_a_replayed_frame_counts_as_sent_by_the_device_and_teaches_its_address) {
    guard.remember({1, channel(0), start}, channels({1, 2}), start, true);
    const auto copy = judge(1, 1, start + 1s);
    EXPECT_TRUE(copy.suspect && !copy.undecided && !copy.looped);
}

}    // namespace
}    // namespace loop_guard_tests
