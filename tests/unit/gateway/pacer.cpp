#include <gateway/pacer.hpp>

#include <gtest/gtest.h>

namespace pacer_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;

namespace {

constexpr TimePoint start{1h};

// 10 bytes per millisecond: 200 bytes are 20 ms.
Pacer ten_a_ms() { return Pacer{{.rate = 10000, .latency = 20ms}}; }

TEST(Pacer, allows_as_many_bytes_as_fit_in_the_latency_on_an_idle_line) {
    Pacer pacer = ten_a_ms();
    EXPECT_EQ(pacer.allowance(21, false, start), 200u);
    pacer.sent(150, start);
    EXPECT_EQ(pacer.allowance(21, false, start), 50u);
    pacer.sent(50, start);
    EXPECT_EQ(pacer.allowance(21, false, start), 0u);
}

TEST(Pacer, a_frame_longer_than_the_latency_is_sent_alone_on_an_idle_line) {
    Pacer pacer = ten_a_ms();
    EXPECT_EQ(pacer.allowance(1000, false, start), 1000u);
    pacer.sent(1000, start);
    EXPECT_EQ(pacer.allowance(1000, false, start + 99ms), 0u);
    EXPECT_EQ(pacer.next_at(1000), start + 100ms);
    EXPECT_EQ(pacer.allowance(1000, false, start + 100ms), 1000u);
}

TEST(Pacer, a_spent_budget_is_available_again_when_half_is_restored) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start), 0u);
    EXPECT_EQ(pacer.next_at(20), start + 10ms);
    EXPECT_EQ(pacer.allowance(20, false, start + 9ms), 0u);
    EXPECT_EQ(pacer.allowance(20, false, start + 10ms), 100u);
    EXPECT_EQ(pacer.next_at(150), start + 15ms) << "a larger frame waits until it fits";
}

TEST(Pacer, an_urgent_frame_is_sent_as_soon_as_it_fits) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start), 0u);
    EXPECT_EQ(pacer.allowance(20, true, start + 1ms), 0u);
    EXPECT_EQ(pacer.allowance(20, true, start + 2ms), 20u);
}

TEST(Pacer, a_late_call_causes_no_burst) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start + 10min), 200u);
    pacer.sent(200, start + 10min);
    EXPECT_EQ(pacer.allowance(20, false, start + 10min), 0u);
}

TEST(Pacer, a_clock_set_back_does_not_stop_sending) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start - 30min), 0u);
    EXPECT_EQ(pacer.next_at(20), start - 30min + 10ms);
    EXPECT_EQ(pacer.allowance(20, false, start - 30min + 10ms), 100u);
}

TEST(Pacer, slows_down_when_the_driver_still_holds_more_bytes) {
    Pacer pacer = ten_a_ms();
    pacer.sent(200, start);
    EXPECT_EQ(pacer.allowance(20, false, start), 0u);
    pacer.correct(180, start + 10ms);    // the line is slower than its rate
    EXPECT_EQ(pacer.allowance(20, false, start + 17ms), 0u);
    EXPECT_EQ(pacer.allowance(20, false, start + 18ms), 100u);
    pacer.correct(0, start + 18ms);
    EXPECT_EQ(pacer.allowance(20, false, start + 18ms), 100u) << "less says nothing";
}

TEST(Pacer, reset_forgets_the_sent_bytes) {
    Pacer pacer = ten_a_ms();
    pacer.sent(1000, start);
    pacer.reset();
    EXPECT_LT(pacer.next_at(20), start);
    EXPECT_EQ(pacer.allowance(20, false, start), 200u);
}

TEST(Pacer, with_a_gap_frames_are_sent_one_by_one_with_a_pause_after_the_end_of_each_on_the_wire) {
    Pacer pacer{{.rate = 10'000, .latency = 20ms, .gap = 15ms}};
    EXPECT_EQ(pacer.allowance(50, false, start), 50u) << "no more than the frame, although 200 bytes would fit";
    pacer.sent(50, start);
    EXPECT_EQ(pacer.allowance(21, true, start + 5ms + 15ms - 1us), 0u) << "not even an urgent one";
    EXPECT_EQ(pacer.next_at(21), start + 20ms);
    EXPECT_EQ(pacer.allowance(21, false, start + 20ms), 21u);
    pacer.sent(10, start + 20ms);
    EXPECT_EQ(pacer.allowance(11, false, start + 20ms), 11u) << "the rest of a frame that the driver took in part";
    pacer.sent(11, start + 20ms);
    pacer.correct(30, start + 21ms);
    EXPECT_EQ(pacer.next_at(21), start + 21ms + 3ms + 15ms) << "the driver still holds some of it";
}

TEST(Pacer, with_a_gap_and_no_rate_a_frame_ends_when_it_is_written) {
    Pacer pacer{{.gap = 15ms}};
    EXPECT_EQ(pacer.allowance(1000, false, start), 1000u);
    pacer.sent(1000, start);
    EXPECT_EQ(pacer.allowance(8, false, start + 14ms), 0u);
    EXPECT_EQ(pacer.allowance(8, false, start + 15ms), 8u);
}

}    // namespace
}    // namespace pacer_tests
