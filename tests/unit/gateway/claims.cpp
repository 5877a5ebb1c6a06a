#include <gateway/claims.hpp>

#include <gtest/gtest.h>

#include <string>

namespace claims_tests {

using namespace anogate;
using namespace ano;
using namespace std::chrono_literals;

namespace {

constexpr ChannelId channel(unsigned n) { return static_cast<ChannelId>(n); }

struct ClaimsTest : testing::Test {
    /// A letter for each due action: a(sked), or S(ilent).
    std::string due(TimePoint now) {
        std::string all;
        while (const auto step = claims.next_due(now)) all += step->silent ? 'S' : 'a';
        return all;
    }
    Claims claims{{.questions = 2, .answer_within = 10ms, .between_tests = 100ms, .late = 5ms}};
    TimePoint start{};
};

TEST_F(ClaimsTest, sends_requests_and_waits_after_each) {
    EXPECT_FALSE(claims.next());
    ASSERT_TRUE(claims.begin(7, channel(3), start));
    EXPECT_EQ(claims.next(), start);
    EXPECT_EQ(due(start), "a");
    EXPECT_EQ(claims.next(), start + 10ms);
    EXPECT_EQ(due(start + 9ms), "");
    EXPECT_EQ(due(start + 10ms), "a");
    EXPECT_EQ(due(start + 19ms), "");
    const auto verdict = claims.next_due(start + 20ms);
    ASSERT_TRUE(verdict && verdict->silent);
    EXPECT_EQ(verdict->address, 7);
    EXPECT_EQ(verdict->claimant, channel(3));
    EXPECT_FALSE(claims.next());
    EXPECT_FALSE(claims.is_due(TimePoint::max() - 1ns));
}

TEST_F(ClaimsTest, allows_one_test_of_an_address_at_a_time_with_a_pause_between_tests) {
    ASSERT_TRUE(claims.begin(7, channel(3), start));
    EXPECT_FALSE(claims.begin(7, channel(4), start));
    EXPECT_TRUE(claims.begin(8, channel(4), start));
    EXPECT_EQ(claims.claimant(7), channel(3));
    claims.end(7);
    EXPECT_FALSE(claims.is_under_way(7));
    EXPECT_FALSE(claims.begin(7, channel(3), start + 99ms));
    EXPECT_EQ(due(start), "a") << "the other";
    EXPECT_TRUE(claims.begin(7, channel(3), start + 100ms));
}

TEST_F(ClaimsTest, the_next_time_is_the_earliest_of_several_tests) {
    claims.begin(7, channel(3), start);
    claims.begin(8, channel(4), start + 5ms);
    EXPECT_EQ(claims.next(), start);
    EXPECT_EQ(due(start), "a");
    EXPECT_EQ(claims.next(), start + 5ms);
    EXPECT_EQ(due(start + 5ms), "a");
    EXPECT_EQ(claims.next(), start + 10ms) << "of the other, whose address comes later, at 15 ms";
}

// The answer may wait in a socket that was not read yet.
TEST_F(ClaimsTest, sends_another_request_if_it_was_late_to_read_the_answer) {
    claims.begin(7, channel(3), start);
    EXPECT_EQ(due(start), "a");
    EXPECT_EQ(due(start + 10ms), "a");
    EXPECT_EQ(due(start + 60ms), "a");
    EXPECT_EQ(due(start + 70ms), "S");
}

TEST_F(ClaimsTest, tests_all_addresses_at_once) {
    for (unsigned a = 0; a < 256; ++a) ASSERT_TRUE(claims.begin(static_cast<std::uint8_t>(a), channel(a % 64), start));
    EXPECT_EQ(due(start), std::string(256, 'a'));
    for (unsigned a = 0; a < 256; a += 2) claims.end(static_cast<std::uint8_t>(a));
    EXPECT_EQ(due(start + 10ms), std::string(128, 'a'));
    EXPECT_EQ(due(start + 20ms), std::string(128, 'S'));
    EXPECT_FALSE(claims.next());
}

}    // namespace
}    // namespace claims_tests
