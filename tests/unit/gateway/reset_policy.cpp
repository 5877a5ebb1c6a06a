#include <gateway/reset_policy.hpp>

#include <gtest/gtest.h>

namespace reset_policy_tests {

using namespace anogate;
using namespace std::chrono_literals;

namespace {
constexpr ano::TimePoint start{1000s};
}

TEST(ResetPolicy, silence_counts_from_the_start) {
    const ResetPolicy policy{10s, start};
    EXPECT_EQ(policy.due(), start + 10s);
}

TEST(ResetPolicy, silence_counts_from_the_last_frame) {
    ResetPolicy policy{10s, start};
    policy.heard(start + 9s);
    EXPECT_EQ(policy.due(), start + 19s);
}

TEST(ResetPolicy, without_a_when_silence_causes_no_pulse) {
    const ResetPolicy policy{std::nullopt, start};
    EXPECT_EQ(policy.due(), std::nullopt);
    EXPECT_TRUE(policy.may_pulse(start));
}

TEST(ResetPolicy, pulses_once_a_minute_at_most) {
    ResetPolicy policy{10s, start};
    policy.pulsed(start + 10s);
    EXPECT_EQ(policy.due(), start + 70s);
    EXPECT_FALSE(policy.may_pulse(start + 69s));
    EXPECT_TRUE(policy.may_pulse(start + 70s));
    EXPECT_EQ(policy.may_pulse_at(), start + 70s);
}

TEST(ResetPolicy, a_silence_longer_than_a_minute_counts_again_after_a_pulse) {
    ResetPolicy policy{5min, start};
    policy.pulsed(start + 300s);
    EXPECT_EQ(policy.due(), start + 600s);
}

TEST(ResetPolicy, a_device_that_sends_after_the_pulse_is_not_reset) {
    ResetPolicy policy{10s, start};
    policy.pulsed(start + 10s);
    policy.heard(start + 65s);
    EXPECT_EQ(policy.due(), start + 75s);
}

}    // namespace reset_policy_tests
