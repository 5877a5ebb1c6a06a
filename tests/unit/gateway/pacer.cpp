#include <gateway/pacer.hpp>

#include <gtest/gtest.h>

namespace pacer_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;

namespace {

constexpr TimePoint start{1h};

// 10 bytes a millisecond: 200 bytes are 20 ms.
Pacer ten_a_ms() { return Pacer{{.rate = 10000, .latency = 20ms}}; }

TEST(Pacer, idle_line_takes_what_fits_in_latency) {
    Pacer pacer = ten_a_ms();
    EXPECT_EQ(pacer.allowance(21, false, start), 200u);
    pacer.sent(150, start);
    EXPECT_EQ(pacer.allowance(21, false, start), 50u);
    pacer.sent(50, start);
    EXPECT_EQ(pacer.allowance(21, false, start), 0u);
}

TEST(Pacer, frame_longer_than_latency_goes_alone_to_an_idle_line) {
    Pacer pacer = ten_a_ms();
    EXPECT_EQ(pacer.allowance(1000, false, start), 1000u);
    pacer.sent(1000, start);
    EXPECT_EQ(pacer.allowance(1000, false, start + 99ms), 0u);
    EXPECT_EQ(pacer.next_at(1000), start + 100ms);
    EXPECT_EQ(pacer.allowance(1000, false, start + 100ms), 1000u);
}

TEST(Pacer, spent_budget_comes_back_by_half) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start), 0u);
    EXPECT_EQ(pacer.next_at(20), start + 10ms);
    EXPECT_EQ(pacer.allowance(20, false, start + 9ms), 0u);
    EXPECT_EQ(pacer.allowance(20, false, start + 10ms), 100u);
    EXPECT_EQ(pacer.next_at(150), start + 15ms) << "a larger frame waits until it fits";
}

TEST(Pacer, urgent_frame_goes_as_soon_as_it_fits) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start), 0u);
    EXPECT_EQ(pacer.allowance(20, true, start + 1ms), 0u);
    EXPECT_EQ(pacer.allowance(20, true, start + 2ms), 20u);
}

TEST(Pacer, late_call_is_no_burst) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start + 10min), 200u);
    pacer.sent(200, start + 10min);
    EXPECT_EQ(pacer.allowance(20, false, start + 10min), 0u);
}

TEST(Pacer, clock_that_goes_back_stops_nothing) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start - 30min), 0u);
    EXPECT_EQ(pacer.next_at(20), start - 30min + 10ms);
    EXPECT_EQ(pacer.allowance(20, false, start - 30min + 10ms), 100u);
}

TEST(Pacer, driver_that_holds_more_slows_it_down) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start), 0u);
    pacer.correct(180, start + 10ms);    // the line is slower than its rate
    EXPECT_EQ(pacer.allowance(20, false, start + 17ms), 0u);
    EXPECT_EQ(pacer.allowance(20, false, start + 18ms), 100u);
    pacer.correct(0, start + 18ms);
    EXPECT_EQ(pacer.allowance(20, false, start + 18ms), 100u) << "less says nothing";
}

TEST(Pacer, reset_forgets_what_was_given) {
    Pacer pacer = ten_a_ms();
    pacer.sent(1000, start);
    pacer.reset();
    EXPECT_LT(pacer.next_at(20), start);
    EXPECT_EQ(pacer.allowance(20, false, start), 200u);
}

}    // namespace
}    // namespace pacer_tests
