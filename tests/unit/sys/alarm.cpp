#include <sys/alarm.hpp>
#include <sys/asio.hpp>

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace alarm_tests {

using namespace anogate;
using namespace std::chrono_literals;

namespace {

struct Alarms : testing::Test {
    std::function<void()> says(char what) {
        return [this, what] { rung += what; };
    }
    asio::io_context io{1};
    AlarmClock clock{io};
    std::string rung;
    const ano::TimePoint now = ano::Clock::now();
};

TEST_F(Alarms, expire_in_the_order_of_their_times_however_they_were_set) {
    Alarm a{clock, says('a')}, b{clock, says('b')}, c{clock, says('c')}, never{clock, says('n')};
    b.set(now + 20ms);
    c.set(now + 30ms);
    a.set(now + 10ms);
    never.set(now + 1h);
    while (rung.size() < 3) io.run_one();
    EXPECT_EQ(rung, "abc");
    EXPECT_GE(ano::Clock::now(), now + 30ms);
    EXPECT_TRUE(never.is_set());
}

TEST_F(Alarms, one_with_slack_expires_together_with_another_and_in_time) {
    ano::TimePoint lazy_rang{};
    Alarm lazy{clock,
               [&] {
                   rung += 'l';
                   lazy_rang = ano::Clock::now();
               },
               10s};
    Alarm later{clock, says('m'), 40ms}, exact{clock, says('e')};
    lazy.set(now + 10ms);
    exact.set(now + 100ms);
    later.set(now + 500ms);
    while (rung.size() < 2) io.run_one();
    EXPECT_EQ(rung, "le");
    EXPECT_GE(lazy_rang, now + 100ms);
    EXPECT_LT(ano::Clock::now(), now + 5s);
    while (rung.size() < 3) io.run_one();
    EXPECT_GE(ano::Clock::now(), now + 540ms);
}

TEST_F(Alarms, set_again_counts_from_the_new_time) {
    Alarm a{clock, says('a')}, b{clock, says('b')};
    a.set(now + 5ms);
    a.set(now + 300ms);
    b.set(now + 15ms);
    b.set_no_later(now + 20ms);
    while (rung.size() < 2) io.run_one();
    EXPECT_EQ(rung, "ba");
}

TEST_F(Alarms, one_that_is_cancelled_or_destroyed_does_not_expire_and_the_loop_ends) {
    Alarm cancelled{clock, says('c')};
    auto gone = std::make_unique<Alarm>(clock, says('g'));
    auto ringer = std::make_unique<Alarm>(clock, [&] {
        rung += 'r';
        gone.reset();    // while it is called
        cancelled.cancel();
    });
    cancelled.set(now + 1h);
    gone->set(now + 1h);
    ringer->set(now + 1ms);
    io.run();    // nothing more to wait for
    EXPECT_EQ(rung, "r");
    ringer->set(ano::Clock::now() + 1h);
    ringer.reset();
    io.restart();
    io.run();
    EXPECT_LT(ano::Clock::now(), now + 1min);
}

TEST_F(Alarms, one_that_is_set_later_does_not_change_the_time_of_the_others) {
    Alarm first{clock, says('x')}, second{clock, says('a')};
    first.set(now + 10ms);
    second.set(now + 20ms);
    first.set(now + 1h);
    while (rung.empty() && io.run_one_for(10s) > 0) {}
    EXPECT_EQ(rung, "a");
}

TEST_F(Alarms, one_that_is_destroyed_does_not_change_the_time_of_the_others) {
    Alarm stays{clock, says('s')};
    auto gone = std::make_unique<Alarm>(clock, says('g'));
    stays.set(now + 20ms);
    gone->set(now + 1h);
    gone.reset();
    while (rung.empty() && io.run_one_for(10s) > 0) {}
    EXPECT_EQ(rung, "s");
}

TEST_F(Alarms, set_no_later_keeps_an_earlier_time) {
    Alarm a{clock, says('a')};
    a.set(now + 10ms);
    a.set_no_later(now + 1h);
    while (rung.empty() && io.run_one_for(10s) > 0) {}
    EXPECT_EQ(rung, "a");
}

TEST_F(Alarms, one_expires_once_and_may_be_set_again_in_its_handler) {
    int times = 0;
    Alarm again{clock, [&] {
                    if (++times < 3) again.set(ano::Clock::now() + 1ms);
                }};
    again.set(now + 1ms);
    io.run();
    EXPECT_EQ(times, 3);
    EXPECT_FALSE(again.is_set());
}

TEST_F(Alarms, one_that_expired_as_the_only_one_may_be_set_again) {
    Alarm again{clock, says('a')};
    for (const char* so_far : {"a", "aa"}) {
        again.set(ano::Clock::now());
        io.restart();
        io.run_for(10s);
        EXPECT_EQ(rung, so_far);
    }
}

TEST_F(Alarms, one_that_is_hurried_expires_after_the_current_work_of_the_loop) {
    Alarm hurried{clock, says('h'), 10s}, unset{clock, says('u')}, due{clock, says('d'), 10s};
    hurried.set(now + 1h);
    due.set(now);    // its slack has not elapsed
    asio::post(io, [&] {
        hurried.hurry();
        hurried.hurry();
        unset.hurry();
        rung += '.';
    });
    io.poll();
    EXPECT_EQ(rung, ".hd") << "and who is due rings with it";
    EXPECT_FALSE(hurried.is_set());
    hurried.set(now + 1h);
    hurried.hurry();
    io.restart();
    io.poll();
    EXPECT_EQ(rung, ".hdh") << "and another time";
}

TEST_F(Alarms, one_that_expired_early_leaves_no_pending_wake_up) {
    Alarm later{clock, says('l')}, again{clock, [&] {
                                             rung += 'a';
                                             again.set(now + 1h);
                                         }};
    later.set(now + 2h);
    again.set(now + 50ms);
    again.hurry();
    while (io.poll() > 0) {}
    EXPECT_EQ(rung, "a");
    EXPECT_EQ(io.run_for(ano::Clock::now() < now + 50ms ? 100ms : 0ms), 0u) << "the timer is set to the next of them";
    again.set(ano::Clock::now());
    while (rung.size() < 2 && io.run_one_for(10s) > 0) {}
    EXPECT_EQ(rung, "aa");
}

TEST(AlarmClock, may_be_destroyed_while_an_alarm_is_pending) {
    asio::io_context io{1};
    std::string rung;
    {
        AlarmClock clock{io};
        Alarm alarm{clock, [&] { rung += 'x'; }};
        alarm.set(ano::Clock::now() + 1h);
        alarm.hurry();
    }
    io.poll();
    EXPECT_EQ(rung, "");
}

}    // namespace
}    // namespace alarm_tests
