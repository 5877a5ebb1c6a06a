// When the next file of a recording begins.
#include <record/rotation.hpp>

#include <gtest/gtest.h>

namespace rotation_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

constexpr FileSoFar file(std::uint64_t bytes, ano::Duration age) { return {bytes, 1, age}; }

TEST(Rotation, without_limits_there_is_one_file) { EXPECT_FALSE(is_time_for_the_next({}, file(~std::uint64_t{0}, 100'000h))); }

TEST(Rotation, a_file_has_at_least_as_many_bytes_as_the_limit) {
    constexpr RotationLimits limits{1000, {}};
    EXPECT_FALSE(is_time_for_the_next(limits, file(999, 100h)));
    EXPECT_TRUE(is_time_for_the_next(limits, file(1000, 0s)));
}

TEST(Rotation, a_file_is_at_least_as_old_as_the_limit) {
    constexpr RotationLimits limits{0, 60s};
    EXPECT_FALSE(is_time_for_the_next(limits, file(1'000'000, 60s - 1ns)));
    EXPECT_TRUE(is_time_for_the_next(limits, file(1, 60s)));
}

TEST(Rotation, the_limit_reached_first_applies) {
    constexpr RotationLimits limits{1000, 60s};
    EXPECT_FALSE(is_time_for_the_next(limits, file(999, 59s)));
    EXPECT_TRUE(is_time_for_the_next(limits, file(999, 60s)));
    EXPECT_TRUE(is_time_for_the_next(limits, file(1000, 59s)));
}

TEST(Rotation, a_file_without_frames_is_not_rotated) { EXPECT_FALSE(is_time_for_the_next({1, 1s}, {500, 0, 100h})); }

TEST(Rotation, the_first_file_has_the_name_and_the_others_a_number) {
    EXPECT_EQ(recording_file_name("flight", 1, RecordingFormat::pcapng), "flight.pcapng");
    EXPECT_EQ(recording_file_name("flight", 2, RecordingFormat::mcap), "flight-2.mcap");
    EXPECT_EQ(recording_file_name("a.b", 12, RecordingFormat::pcapng), "a.b-12.pcapng");
}

}    // namespace
}    // namespace rotation_tests
