#include <gateway/blink.hpp>

#include <gtest/gtest.h>

using namespace anogate;
using namespace std::chrono_literals;

namespace {

/// Traffic every `pause` for a second, and the light put out `late` after its time: how often it went on.
int blinks_in_a_second(ano::Duration pause, ano::Duration late = 0ms) {
    Blink blink;
    bool lit = false;
    int count = 0;
    const ano::TimePoint start{10s};
    ano::TimePoint next = start;
    for (ano::TimePoint now = start; now < start + 1s; now += 100us) {
        if (lit && now >= blink.lit_until() + late) {
            blink.end(now);
            lit = false;
        }
        if (now < next) continue;
        next += pause;
        if (blink.traffic(now)) {
            EXPECT_FALSE(lit);
            lit = true;
            ++count;
        }
    }
    return count;
}

}  // namespace

TEST(Blink, is_seen_for_one_frame) {
    Blink blink;
    const ano::TimePoint now{10s};
    EXPECT_TRUE(blink.traffic(now));
    EXPECT_EQ(blink.lit_until(), now + 25ms);
}

TEST(Blink, blinks_with_slow_traffic) {
    EXPECT_EQ(blinks_in_a_second(100ms), 10);
    EXPECT_EQ(blinks_in_a_second(250ms), 4);
}

TEST(Blink, blinks_twenty_times_a_second_however_much_traffic) {
    EXPECT_EQ(blinks_in_a_second(1ms), 20);
    EXPECT_EQ(blinks_in_a_second(100us), 20);
}

TEST(Blink, is_dark_as_long_as_it_should_be_when_it_went_out_late) {
    Blink blink;
    const ano::TimePoint now{10s};
    blink.traffic(now);
    blink.end(now + 60ms);
    EXPECT_FALSE(blink.traffic(now + 84ms));
    EXPECT_TRUE(blink.traffic(now + 85ms));
    EXPECT_LE(blinks_in_a_second(1ms, 20ms), 15);
}
