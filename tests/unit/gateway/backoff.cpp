#include <gateway/backoff.hpp>

#include <gtest/gtest.h>

namespace backoff_tests {

using namespace anogate;
using namespace std::chrono_literals;

TEST(Backoff, retries_at_once_then_doubles_up_to_a_second) {
    Backoff backoff;
    ano::TimePoint now{};
    for (const auto pause : {0ms, 100ms, 200ms, 400ms, 800ms, 1000ms, 1000ms, 1000ms}) {
        EXPECT_EQ(backoff.retry_at(now), now + pause);
        now += pause;
    }
}

TEST(Backoff, of_a_peer_in_a_network_doubles_up_to_five_seconds) {
    Backoff backoff{Backoff::network};
    ano::TimePoint now{};
    for (const auto pause : {0ms, 100ms, 200ms, 400ms, 800ms, 1600ms, 3200ms, 5000ms, 5000ms}) {
        EXPECT_EQ(backoff.retry_at(now), now + pause);
        now += pause;
    }
}

TEST(Backoff, starts_over_after_a_second_up) {
    Backoff backoff;
    ano::TimePoint now{};
    for (int i = 0; i < 6; ++i) now = backoff.retry_at(now);
    backoff.came_up(now);
    now += 1s;
    EXPECT_EQ(backoff.retry_at(now), now);
    EXPECT_EQ(backoff.retry_at(now), now + 100ms);
}

TEST(Backoff, a_link_that_opens_and_fails_at_once_does_not_spin) {
    Backoff backoff;
    ano::TimePoint now{};
    int tries = 0;
    while (now < ano::TimePoint{} + 10s) {
        now = backoff.retry_at(now);
        backoff.came_up(now);
        ++tries;
    }
    EXPECT_LE(tries, 15);
}

}    // namespace backoff_tests
