#include <gateway/blink.hpp>

#include <gtest/gtest.h>

namespace blink_tests {

using namespace anogate;
using namespace std::chrono_literals;

namespace {

/// Traffic every `pause` for a second, with each step `late` after its time: returns how often the light was switched on.
int blinks_in_a_second(ano::Duration pause, ano::Duration late = 0ms) {
    Blink blink;
    bool stepping = false;
    int count = 0;
    const ano::TimePoint start{10s};
    ano::TimePoint next = start;
    for (ano::TimePoint now = start; now < start + 1s; now += 100us) {
        if (now >= next) {
            next += pause;
            stepping = blink.traffic() || stepping;
        }
        if (!stepping || now < blink.due() + late) continue;
        stepping = blink.step(now);
        count += stepping ? 1 : 0;
    }
    return count;
}

TEST(Blink, blinks_visibly_for_a_single_frame) {
    Blink blink;
    const ano::TimePoint now{10s};
    EXPECT_TRUE(blink.traffic());
    EXPECT_LE(blink.due(), now);
    EXPECT_TRUE(blink.step(now));
    EXPECT_FALSE(blink.traffic()) << "it is shown already";
    EXPECT_EQ(blink.due(), now + 25ms);
    EXPECT_FALSE(blink.step(now + 25ms));
}

TEST(Blink, shows_traffic_of_the_dark_phase_later) {
    Blink blink;
    const ano::TimePoint now{10s};
    blink.traffic();
    blink.step(now);
    blink.step(now + 25ms);
    EXPECT_TRUE(blink.traffic());
    EXPECT_FALSE(blink.traffic()) << "one step is enough for both";
    EXPECT_EQ(blink.due(), now + 50ms);
    EXPECT_TRUE(blink.step(now + 50ms));
}

TEST(Blink, blinks_with_slow_traffic) {
    EXPECT_EQ(blinks_in_a_second(100ms), 10);
    EXPECT_EQ(blinks_in_a_second(250ms), 4);
}

TEST(Blink, blinks_twenty_times_a_second_under_heavy_traffic) {
    EXPECT_EQ(blinks_in_a_second(1ms), 20);
    EXPECT_EQ(blinks_in_a_second(100us), 20);
}

TEST(Blink, stays_dark_for_the_full_time_when_it_turned_off_late) {
    Blink blink;
    const ano::TimePoint now{10s};
    blink.traffic();
    blink.step(now);
    blink.step(now + 60ms);
    EXPECT_EQ(blink.due(), now + 85ms);
    EXPECT_LE(blinks_in_a_second(1ms, 20ms), 15);
}

}    // namespace
}    // namespace blink_tests
