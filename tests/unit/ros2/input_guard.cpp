#include <ros2/input_guard.hpp>

#include <gtest/gtest.h>

namespace input_guard_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

/// A message of publisher `who` that was sent at `sent` and received at `received`, by two clocks.
struct Publishing {
    InputGuard guard;
    ano::TimePoint start{1000s};

    InputFault receive(std::uint8_t who, ano::Duration sent, ano::Duration received, ano::Duration waited = 0ms) {
        constexpr std::uint64_t other_clock = 77'000'000'000'000;
        Sample sample;
        sample.publisher[0] = who;
        sample.sent_ns = other_clock + static_cast<std::uint64_t>(sent.count());
        sample.received_ns = static_cast<std::uint64_t>(received.count());
        sample.received_at = start + received;
        return guard.check(sample, start + received + waited);
    }
};

TEST(InputGuard, one_publisher_at_a_time) {
    Publishing p;
    EXPECT_EQ(p.receive(1, 0ms, 1ms), InputFault::none);
    EXPECT_EQ(p.receive(2, 100ms, 101ms), InputFault::other_publisher);
    EXPECT_EQ(p.receive(1, 200ms, 201ms), InputFault::none);
    EXPECT_EQ(p.receive(2, 690ms, 691ms), InputFault::other_publisher);
    EXPECT_EQ(p.receive(2, 710ms, 711ms), InputFault::none);
    EXPECT_EQ(p.receive(1, 720ms, 721ms), InputFault::other_publisher);
}

TEST(InputGuard, names_the_publisher_while_it_sends) {
    Publishing p;
    EXPECT_FALSE(p.guard.publisher(p.start));
    p.receive(9, 0ms, 0ms);
    ASSERT_TRUE(p.guard.publisher(p.start + 499ms));
    EXPECT_EQ(format_guid(*p.guard.publisher(p.start)), "09.00.00.00.00.00.00.00.00.00.00.00.00.00.00.00");
    EXPECT_FALSE(p.guard.publisher(p.start + 500ms));
}

TEST(InputGuard, a_message_that_waited_in_the_network_is_old_whatever_the_clock_of_its_publisher) {
    Publishing p;
    EXPECT_EQ(p.receive(1, 0ms, 0ms), InputFault::none);
    EXPECT_EQ(p.receive(1, 100ms, 590ms), InputFault::none);    // 490 ms later than the fastest
    EXPECT_EQ(p.receive(1, 200ms, 710ms), InputFault::old);
    // A cable was off for 15 s: what was sent meanwhile arrives now.
    EXPECT_EQ(p.receive(1, 1s, 16s), InputFault::old);
    EXPECT_EQ(p.receive(1, 2s, 16s), InputFault::old);
    EXPECT_EQ(p.receive(1, 16s, 16001ms), InputFault::none);
}

TEST(InputGuard, a_message_that_waited_in_this_program_is_old) {
    Publishing p;
    EXPECT_EQ(p.receive(1, 0ms, 0ms), InputFault::none);
    EXPECT_EQ(p.receive(1, 100ms, 100ms, 501ms), InputFault::old);
}

TEST(InputGuard, a_clock_that_was_set_back_is_followed_after_5_s) {
    Publishing p;
    EXPECT_EQ(p.receive(1, 100s, 100s), InputFault::none);
    for (auto t = 0ms; t < 5s; t += 500ms) EXPECT_EQ(p.receive(1, 40s + t, 101s + t), InputFault::old);
    EXPECT_EQ(p.receive(1, 45100ms, 106100ms), InputFault::none);
}

TEST(InputGuard, an_old_message_keeps_no_other_publisher_out) {
    Publishing p;
    EXPECT_EQ(p.receive(1, 0ms, 0ms), InputFault::none);
    EXPECT_EQ(p.receive(1, 100ms, 900ms), InputFault::old);
    EXPECT_EQ(p.receive(2, 1000ms, 1000ms), InputFault::none);
}

}    // namespace
}    // namespace input_guard_tests
