#include <gateway/class_shares.hpp>

#include <gtest/gtest.h>

#include <vector>

using namespace anogate;

namespace class_shares_tests {
namespace {

std::vector<std::size_t> sent(ClassShares& shares, const ClassShares::Sizes& next, int frames) {
    std::vector<std::size_t> classes;
    for (int i = 0; i < frames; ++i) {
        const std::size_t chosen = shares.choose(next);
        shares.leaves(chosen, next);
        classes.push_back(chosen);
    }
    return classes;
}

TEST(ClassShares, after_nine_urgent_frames_one_telemetry_frame_of_that_size_is_sent) {
    ClassShares shares;
    EXPECT_EQ(sent(shares, {100, 100, 0}, 20),
              (std::vector<std::size_t>{0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}));
}

TEST(ClassShares, shares_that_are_due_expire_when_nothing_waits) {
    ClassShares shares;
    sent(shares, {100, 100, 0}, 9);
    shares.clear();
    EXPECT_EQ(shares.choose({100, 100, 0}), 0u);
}

TEST(ClassShares, nothing_is_sent_when_nothing_waits) { EXPECT_EQ(ClassShares{}.choose({}), traffic_classes); }

}    // namespace
}    // namespace class_shares_tests
