#include <gateway/untaken.hpp>

#include <gtest/gtest.h>

using namespace anogate;
using namespace std::chrono_literals;

TEST(Untaken, lasts_as_long_as_it_flows) {
    Untaken untaken;
    ano::TimePoint now{1h};
    EXPECT_EQ(untaken.duration(now), std::nullopt);
    untaken.note(now);
    EXPECT_EQ(untaken.duration(now), 0s);
    for (int n = 0; n < 5; ++n) untaken.note(now += 2s);
    EXPECT_EQ(untaken.duration(now + 1s), 11s);
    EXPECT_EQ(untaken.duration(now + Untaken::pause), std::nullopt);
    untaken.note(now += Untaken::pause);
    EXPECT_EQ(untaken.duration(now + 1s), 1s) << "it began again";
}
