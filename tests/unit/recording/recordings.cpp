#include <recording/recordings.hpp>

#include <gtest/gtest.h>

namespace anogate::recordings_tests {
namespace {

using namespace std::chrono_literals;

TEST(LimitsOfRecordings, are_those_of_the_configuration) {
    RecordSettings settings;
    settings.keep_size = 7'000'000;
    settings.keep_age = std::chrono::hours{2};
    settings.keep_free = 9'000'000'000;
    const KeepLimits limits = limits_of(settings);
    EXPECT_EQ(limits.bytes, 7'000'000u);
    EXPECT_EQ(limits.age, std::chrono::hours{2});
    EXPECT_EQ(limits.free, 9'000'000'000u);
}

TEST(LimitsOfRecordings, leave_enough_free_space_to_continue_writing) {
    RecordSettings settings;
    settings.free = settings.keep_free = 500'000'000;
    EXPECT_EQ(limits_of(settings).free, room_needed(500'000'000));
    EXPECT_GT(room_needed(500'000'000), 500'000'000u);
    settings.keep_free = 0;
    EXPECT_EQ(limits_of(settings).free, 0u) << "none is deleted for that";
    settings.free = 0;
    settings.keep_free = 1'000'000;
    EXPECT_EQ(limits_of(settings).free, 1'000'000u) << "it is written until the disk is full";
}

}    // namespace
}    // namespace anogate::recordings_tests
