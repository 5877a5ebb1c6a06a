// A line that accepts no bytes, in simulated time.
#include <gateway/drain_watch.hpp>

#include <gtest/gtest.h>

namespace anogate::drain_watch_tests {
namespace {

using namespace std::chrono_literals;

struct Line {
    DrainWatch watch;
    ano::TimePoint now{1000s};
    std::uint64_t left = 0;

    bool is_stopped_after(ano::Duration time, bool waits = true, std::uint64_t bytes_each = 0) {
        bool is_stopped = false;
        for (const auto end = now + time; now < end; now += 100ms, left += bytes_each)
            is_stopped = watch.accepts_nothing(left, waits, now);
        return is_stopped;
    }
};

TEST(DrainWatch, a_line_that_sends_nothing_for_3_s_is_stopped) {
    Line line;
    EXPECT_FALSE(line.is_stopped_after(2900ms));
    EXPECT_TRUE(line.is_stopped_after(300ms));
    EXPECT_FALSE(line.is_stopped_after(200ms, true, 1)) << "it goes on";
}

TEST(DrainWatch, a_slow_line_or_one_without_waiting_data_is_not_stopped) {
    Line line;
    EXPECT_FALSE(line.is_stopped_after(10s, true, 1));
    EXPECT_FALSE(line.is_stopped_after(10s, false));
    EXPECT_FALSE(line.is_stopped_after(2900ms)) << "it waits only now";
}

TEST(DrainWatch, time_without_observation_does_not_count) {
    Line line;
    line.is_stopped_after(200ms);
    line.now += 1min;
    EXPECT_FALSE(line.is_stopped_after(2900ms));
    EXPECT_TRUE(line.is_stopped_after(300ms));
}

}    // namespace
}    // namespace anogate::drain_watch_tests
