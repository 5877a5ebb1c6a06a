#include <gateway/hello.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <vector>

using namespace anogate;
using namespace std::chrono_literals;

namespace hello_tests {
namespace {

constexpr ano::TimePoint start{1h};
constexpr ano::TimePoint never{};    // heard

using Due = std::optional<ano::TimePoint>;

TEST(Hello, is_a_request_of_a_host_for_the_device_info) {
    EXPECT_EQ(support::Bytes(hello_frame.begin(), hello_frame.end()), support::hex("AB FE FF E0 03 00 00 00 00 8B 3B"));
}

TEST(Hello, is_not_sent_while_the_link_is_down) {
    Hello hello{2s};
    EXPECT_EQ(hello.due(never), Due{});
    hello.came_up(start);
    hello.went_down();
    EXPECT_EQ(hello.due(never), Due{});
}

TEST(Hello, is_first_sent_after_a_second_and_repeated_while_the_device_is_silent) {
    Hello hello{2s};
    hello.came_up(start);
    EXPECT_EQ(hello.due(never), start + 1s);
    hello.sent(start + 1s, never);
    EXPECT_EQ(hello.due(never), start + 3s);
    hello.sent(start + 3s, never);
    EXPECT_EQ(hello.due(never), start + 5s);
}

TEST(Hello, treats_the_device_as_possibly_deaf_before_every_third_unanswered_one) {
    Hello hello{2s};
    hello.came_up(start);
    std::vector<bool> deaf;
    for (int i = 1; i <= 7; ++i) {
        deaf.push_back(hello.may_be_deaf(never));
        hello.sent(start + i * 2s, never);
    }
    EXPECT_EQ(deaf, (std::vector<bool>{false, false, true, false, false, true, false}));
    EXPECT_FALSE(hello.may_be_deaf(start + 15s)) << "it was heard";
    hello.sent(start + 17s, start + 15s);
    EXPECT_FALSE(hello.may_be_deaf(start + 15s));
    hello.sent(start + 19s, start + 15s);
    EXPECT_TRUE(hello.may_be_deaf(start + 15s));
}

TEST(Hello, is_postponed_by_every_received_frame) {
    Hello hello{2s};
    hello.came_up(start);
    EXPECT_EQ(hello.due(start + 900ms), start + 1900ms);
    EXPECT_EQ(hello.due(start + 1800ms), start + 2800ms);
    hello.sent(start + 2800ms, never);
    EXPECT_EQ(hello.due(start + 2850ms), start + 4800ms) << "an answer does not make it sooner than the interval";
    EXPECT_EQ(hello.due(start + 4500ms), start + 5500ms);
}

TEST(Hello, starts_over_when_the_link_is_up_again) {
    Hello hello{10s};
    hello.came_up(start);
    hello.sent(start + 1s, never);
    hello.went_down();
    hello.came_up(start + 2s);
    EXPECT_EQ(hello.due(start + 100ms), start + 3s) << "what was heard before counts for nothing, and neither does what was said";
}

TEST(Hello, pauses_for_a_minute_after_a_firmware_frame) {
    Hello hello{2s};
    hello.came_up(start);
    hello.saw_firmware(start + 500ms);
    EXPECT_EQ(hello.due(never), start + 60500ms);
    hello.went_down();    // the device restarts
    hello.came_up(start + 5s);
    EXPECT_EQ(hello.due(never), start + 60500ms);
    EXPECT_EQ(hello.due(start + 60s), start + 61s);
}

TEST(Hello, is_sent_at_most_once_a_second) {
    Hello hello{10ms};
    hello.came_up(start);
    hello.sent(start + 1s, never);
    EXPECT_EQ(hello.due(never), start + 2s);
}

}    // namespace
}    // namespace hello_tests
