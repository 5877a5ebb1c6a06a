#include <gateway/undelivered.hpp>

#include <gtest/gtest.h>

namespace untaken_tests {

using namespace anogate;
using namespace std::chrono_literals;

TEST(Undelivered, lasts_as_long_as_frames_arrive) {
    Undelivered undelivered;
    ano::TimePoint now{1h};
    EXPECT_EQ(undelivered.duration(now), std::nullopt);
    undelivered.note(now);
    EXPECT_EQ(undelivered.duration(now), 0s);
    for (int n = 0; n < 5; ++n) undelivered.note(now += 2s);
    EXPECT_EQ(undelivered.duration(now + 1s), 10s);
    EXPECT_EQ(undelivered.duration(now + Undelivered::pause), std::nullopt);
    undelivered.note(now += Undelivered::pause);
    undelivered.note(now += 1s);
    EXPECT_EQ(undelivered.duration(now + 1s), 1s) << "it began again";
}

TEST(Undelivered, lasts_only_from_the_first_to_the_last_frame) {
    Undelivered undelivered;
    const ano::TimePoint now{1h};
    undelivered.note(now);
    undelivered.note(now + 400ms);
    EXPECT_EQ(undelivered.duration(now + 3s), 400ms);
}

TEST(Undelivered, ends_when_a_frame_has_a_receiver) {
    Undelivered undelivered;
    ano::TimePoint now{1h};
    for (int n = 0; n < 5; ++n) undelivered.note(now += 1s);
    undelivered.delivered();
    EXPECT_EQ(undelivered.duration(now), std::nullopt);
    undelivered.note(now += 1s);
    EXPECT_EQ(undelivered.duration(now), 0s) << "it began again";
}

}    // namespace untaken_tests
