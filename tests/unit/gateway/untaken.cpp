#include <gateway/untaken.hpp>

#include <gtest/gtest.h>

namespace untaken_tests {

using namespace anogate;
using namespace std::chrono_literals;

TEST(Untaken, lasts_as_long_as_frames_arrive) {
    Untaken untaken;
    ano::TimePoint now{1h};
    EXPECT_EQ(untaken.duration(now), std::nullopt);
    untaken.note(now);
    EXPECT_EQ(untaken.duration(now), 0s);
    for (int n = 0; n < 5; ++n) untaken.note(now += 2s);
    EXPECT_EQ(untaken.duration(now + 1s), 10s);
    EXPECT_EQ(untaken.duration(now + Untaken::pause), std::nullopt);
    untaken.note(now += Untaken::pause);
    untaken.note(now += 1s);
    EXPECT_EQ(untaken.duration(now + 1s), 1s) << "it began again";
}

TEST(Untaken, lasts_only_from_the_first_to_the_last_frame) {
    Untaken untaken;
    const ano::TimePoint now{1h};
    untaken.note(now);
    untaken.note(now + 400ms);
    EXPECT_EQ(untaken.duration(now + 3s), 400ms);
}

TEST(Untaken, ends_when_a_frame_has_a_receiver) {
    Untaken untaken;
    ano::TimePoint now{1h};
    for (int n = 0; n < 5; ++n) untaken.note(now += 1s);
    untaken.taken();
    EXPECT_EQ(untaken.duration(now), std::nullopt);
    untaken.note(now += 1s);
    EXPECT_EQ(untaken.duration(now), 0s) << "it began again";
}

}    // namespace untaken_tests
