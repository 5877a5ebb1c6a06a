#include <gateway/arrival.hpp>

#include <gtest/gtest.h>

namespace arrival_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::Duration;
using ano::TimePoint;

namespace {

/// A loop with its clocks, and one wire.
class ArrivalTest : public testing::Test {
protected:
    static constexpr Duration period = 100ms;

    ArrivalTest() {
        turn();
        loop.beat(period);
        wire.found_empty(loop.clocks());
    }

    void pass(Duration time) {
        clocks.now += time;
        clocks.boot += time;
        clocks.real += time;
    }
    void suspend(Duration time) {
        clocks.boot += time;
        clocks.real += time;
    }
    void set_clock(Duration by) { clocks.real += by; }
    StallDetector::Turn turn() { return loop.turn(clocks); }
    void beat() {
        if (turn().stood == 0s) loop.end_standstill();
        loop.beat(period);
    }
    /// The behaviour of an idle loop.
    void idle(Duration time) {
        for (Duration end{}; end < time; end += period) {
            pass(period);
            beat();
        }
    }
    /// A stamp of the present time.
    Duration stamp() const { return clocks.real; }

    Duration age_by(Duration stamp) {
        turn();
        return clocks.now - wire.stamped(stamp, loop);
    }
    Duration age() {
        turn();
        return clocks.now - wire.unstamped(loop);
    }

    ClockReading clocks{TimePoint{1h}, 2h, 490'000h};
    StallDetector loop;
    Arrival wire;
};

TEST_F(ArrivalTest, data_that_waited_while_no_program_ran_is_as_old_as_the_pause) {
    const ClockReading stopped = clocks;
    pass(3s);
    turn();
    wire.unread_since(stopped);
    EXPECT_EQ(age(), 3s);
    pass(1s);
    EXPECT_EQ(age(), 4s) << "until it is found empty";
    EXPECT_EQ(age_by(stopped.real + 1s), 3s) << "by its stamp";
    wire.found_empty(loop.before());
    pass(10ms);
    EXPECT_EQ(age(), 0s);
}

using Stamped = ArrivalTest;

TEST_F(Stamped, counts_from_the_stamp) {
    idle(5s);
    const Duration came = stamp();
    pass(7ms);
    EXPECT_EQ(age_by(came), 7ms);
}

TEST_F(Stamped, counts_through_a_stall) {
    idle(5s);
    pass(2s);
    const Duration early = stamp();
    pass(7s);
    const Duration late = stamp();
    pass(1ms);
    EXPECT_EQ(age_by(early), 7001ms);
    EXPECT_EQ(age_by(late), 1ms);
}

TEST_F(Stamped, counts_while_the_machine_sleeps) {
    idle(1s);
    pass(10ms);
    const Duration came = stamp();
    suspend(8h);
    pass(1ms);
    EXPECT_EQ(age_by(came), 8h + 1ms);
}

TEST_F(Stamped, of_the_future_counts_as_now) {
    idle(1s);
    EXPECT_EQ(age_by(stamp() + 10ms), 0s);
}

TEST_F(Stamped, is_no_older_than_the_last_time_the_wire_was_empty) {
    idle(1s);
    wire.found_empty(loop.clocks());
    pass(30ms);
    EXPECT_EQ(age_by(stamp() - 49ms), 30ms);
}

TEST_F(Stamped, is_ignored_when_the_clock_was_set) {
    for (const Duration step : {Duration{1h}, Duration{-1h}, Duration{200ms}, Duration{-200ms}}) {
        idle(5s);
        const Duration came = stamp();
        set_clock(step);
        pass(1ms);
        EXPECT_EQ(age_by(came), 0s) << step.count();    // the loop ran, so it can't have waited
        wire.found_empty(loop.clocks());
    }
}

TEST_F(Stamped, is_as_old_as_the_stall_when_the_clock_was_set_meanwhile) {
    for (const Duration step : {Duration{1h}, Duration{-1h}}) {
        idle(5s);
        const Duration came = stamp();
        pass(4s);
        set_clock(step);
        pass(5s);
        const Duration after = stamp();
        EXPECT_EQ(age_by(came), 9s) << step.count();
        EXPECT_EQ(age_by(after), 9s) << step.count();
        wire.found_empty(loop.clocks());
        pass(1ms);
        EXPECT_EQ(age_by(stamp()), 0s) << step.count();
        wire.found_empty(loop.clocks());
        beat();
    }
}

TEST_F(Stamped, follows_a_clock_that_is_adjusted_slowly) {
    idle(5s);
    for (int i = 0; i < 1000; ++i) {
        set_clock(49ms);
        idle(1s);
        const Duration came = stamp();
        pass(3ms);
        EXPECT_EQ(age_by(came), 3ms);
        wire.found_empty(loop.clocks());
    }
}

// A stall may begin immediately after the read has returned.
TEST_F(Stamped, is_no_younger_when_a_stall_follows_the_read_immediately) {
    idle(1s);
    turn();
    pass(1ms);    // the read finds nothing more
    pass(2s);     // and the clocks are read after the stall
    const Duration came = stamp() - 1s;
    turn();
    wire.found_empty(loop.before());
    EXPECT_EQ(age_by(came), 1s);
}

using Unstamped = ArrivalTest;

TEST_F(Unstamped, is_as_old_as_the_time_without_a_read_although_the_loop_ran) {
    idle(1s);
    const ClockReading stopped = clocks;
    pass(40ms);
    wire.unread_since(stopped);
    EXPECT_EQ(age(), 40ms);
    EXPECT_TRUE(wire.is_behind());
}

TEST_F(Unstamped, is_no_younger_when_a_stall_follows_the_read_immediately) {
    idle(1s);
    turn();
    pass(2s);
    turn();
    wire.found_empty(loop.before());
    pass(1ms);
    EXPECT_EQ(age(), 2001ms);
}

TEST_F(Unstamped, counts_as_now_while_the_loop_runs) {
    EXPECT_EQ(age(), 0s);
    idle(1h);
    pass(90ms);
    EXPECT_EQ(age(), 0s);
    pass(10ms + StallDetector::lateness);
    EXPECT_EQ(age(), 0s);
}

TEST_F(Unstamped, is_as_old_as_a_stall) {
    idle(1s);
    pass(9s);
    EXPECT_EQ(age(), 9s);
    pass(1ms);
    EXPECT_EQ(age(), 9001ms);    // the stall continues
    beat();
    EXPECT_TRUE(wire.is_behind());
    pass(1ms);
    EXPECT_EQ(age(), 9002ms);
    wire.found_empty(loop.clocks());
    EXPECT_FALSE(wire.is_behind());
    EXPECT_EQ(age(), 0s);
}

TEST_F(Unstamped, is_no_older_than_the_last_time_the_wire_was_empty) {
    idle(1s);
    pass(50ms);
    turn();
    wire.found_empty(loop.clocks());
    pass(9s);
    EXPECT_EQ(age(), 9s);
}

TEST_F(Unstamped, counts_as_now_where_nothing_waited) {
    idle(1s);
    pass(9s);
    beat();    // a beat noticed the stall: other wires may still have old data
    EXPECT_TRUE(loop.is_behind());
    pass(period);
    beat();
    EXPECT_FALSE(loop.is_behind());
    pass(20ms);
    EXPECT_EQ(age(), 0s);
    idle(1h);
    EXPECT_EQ(age(), 0s);
}

TEST_F(Unstamped, is_as_old_as_the_sleep_of_the_machine) {
    idle(1s);
    pass(10ms);
    suspend(3s);
    pass(10ms);
    EXPECT_EQ(age(), 3020ms);
}

TEST_F(Unstamped, is_as_old_as_the_first_stall_until_it_is_read) {
    idle(1s);
    pass(9s);
    EXPECT_EQ(age(), 9s);
    pass(2s);
    EXPECT_EQ(age(), 11s);
}

using Watch = ArrivalTest;

TEST_F(Watch, reports_stalls_longer_than_half_a_second) {
    idle(10s);
    EXPECT_EQ(loop.standstills(), 0u);
    pass(StallDetector::min_reported);
    EXPECT_FALSE(turn().is_reported);
    EXPECT_EQ(loop.standstills(), 0u);
    beat();
    pass(StallDetector::min_reported + 1ms);
    EXPECT_TRUE(turn().is_reported);
    EXPECT_FALSE(turn().is_reported) << "once";
    EXPECT_EQ(loop.standstills(), 1u);
    beat();
    pass(9s);
    beat();
    EXPECT_EQ(loop.standstills(), 2u);
    EXPECT_EQ(loop.longest(), 9s - period);
    pass(3s);
    beat();
    EXPECT_EQ(loop.standstills(), 3u);
    EXPECT_EQ(loop.longest(), 9s - period) << "the last one was shorter";
}

// Between slow beats, a stall is recognised by the age of the data that waited to be read.
TEST_F(Watch, data_read_before_the_end_of_a_stall_or_just_after_it_may_have_waited) {
    const auto may_have_waited = [&] { return loop.may_have_waited(clocks.now); };
    EXPECT_FALSE(may_have_waited());
    pass(period + StallDetector::min_reported / 2);
    turn();
    EXPECT_FALSE(may_have_waited()) << "the machine was busy";
    loop.beat(period);
    const TimePoint before = clocks.now;
    pass(period + 2 * StallDetector::min_reported);
    turn();
    EXPECT_TRUE(loop.may_have_waited(before));
    EXPECT_TRUE(may_have_waited());
    pass(StallDetector::catching_up);
    EXPECT_FALSE(may_have_waited());
}

TEST_F(Watch, detects_a_stall_by_the_age_of_waiting_data) {
    loop.beat(520ms);
    pass(10ms);
    turn();
    pass(5ms);
    const Duration came = stamp();
    pass(StallDetector::min_reported + 1ms);
    EXPECT_FALSE(turn().is_reported);
    const TimePoint arrived = wire.stamped(came, loop);
    EXPECT_EQ(loop.waited(clocks.now), 0s) << "it woke the loop, which had nothing to do before";
    EXPECT_EQ(loop.waited(arrived), StallDetector::min_reported + 1ms);
    EXPECT_EQ(loop.waited(arrived), 0s) << "once";
    EXPECT_EQ(loop.standstills(), 1u);
    EXPECT_EQ(loop.longest(), StallDetector::min_reported + 1ms);
}

TEST_F(Watch, remembers_a_stall_through_a_turn_just_too_short_to_be_reported) {
    loop.beat(10s);
    const Duration came = stamp();
    pass(2s);
    turn();
    pass(StallDetector::min_reported);
    turn();
    EXPECT_EQ(loop.waited(wire.stamped(came, loop)), 2s);
}

// A loop that can't keep up is not a stall.
TEST_F(Watch, reports_no_stall_for_data_that_waited_while_the_loop_ran) {
    const Duration came = stamp();
    idle(900ms);
    EXPECT_EQ(loop.waited(wire.stamped(came, loop)), 0s);
    pass(700ms);
    EXPECT_TRUE(turn().is_reported);
    EXPECT_EQ(loop.waited(wire.stamped(came, loop)), 0s) << "nor when the beat has told it";
    EXPECT_EQ(loop.standstills(), 1u);
}

TEST_F(Watch, reports_how_long_the_machine_slept) {
    idle(1s);
    suspend(8h);
    pass(1ms);
    const StallDetector::Turn woken = turn();
    EXPECT_EQ(woken.suspended, 8h);
    EXPECT_EQ(woken.stood, 8h);
    EXPECT_EQ(loop.standstills(), 1u);
    pass(1ms);
    EXPECT_EQ(turn().suspended, 0s);
}

TEST_F(Watch, does_not_mistake_the_delay_between_two_clock_readings_for_sleep) {
    idle(1s);
    clocks.boot += 20us;
    EXPECT_EQ(turn().suspended, 0s);
    clocks.boot -= 20us;
    EXPECT_EQ(turn().suspended, 0s);
    pass(period + 40ms);
    clocks.boot += 20ms;    // the thread was interrupted between the two reads
    EXPECT_EQ(turn().stood, 0s) << "busy";
}

TEST_F(Watch, does_not_begin_before_the_first_beat) {
    StallDetector fresh;
    EXPECT_EQ(fresh.turn(clocks).stood, 0s);
    pass(1h);
    EXPECT_EQ(fresh.turn(clocks).stood, 0s);
    EXPECT_EQ(fresh.standstills(), 0u);
}

}    // namespace
}    // namespace arrival_tests
