#include <ros2/velocity_control.hpp>

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace velocity_control_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

constexpr std::uint8_t attitude = 0, position = 2;

struct Flying {
    VelocityControl control{42'500, {position}};    // hovers at 42.5 %
    ano::TimePoint start{1000s};
    VelocityFrame frame{};

    InputFault twist(ano::Duration at, Twist values = {{1, 0, 0}, {0, 0, 0}}) {
        return control.on_twist(values, start + at, frame);
    }
    void mode(ano::Duration at, std::uint8_t mode = position) { control.on_mode(mode, start + at); }
    std::optional<VelocityFrame> time(ano::Duration at) { return control.on_time(start + at); }
};

TEST(VelocityControl, sets_velocities_yaw_rate_and_the_throttle_of_hovering) {
    Flying f;
    f.mode(0ms);
    EXPECT_EQ(f.twist(1ms, {{1.5, -0.25, 0.1}, {9, 9, std::numbers::pi / 2}}), InputFault::none);
    EXPECT_EQ(f.frame, (VelocityFrame{425, 90, 150, -25, 10}));
}

TEST(VelocityControl, velocities_and_yaw_rate_are_limited_to_what_a_frame_can_state) {
    Flying f;
    f.mode(0ms);
    EXPECT_EQ(f.twist(1ms, {{1e9, -1e9, 327.67}, {0, 0, -1e9}}), InputFault::none);
    EXPECT_EQ(f.frame, (VelocityFrame{425, -200, 32767, -32767, 32767}));
}

TEST(VelocityControl, numbers_that_are_not_finite_are_refused) {
    Flying f;
    f.mode(0ms);
    EXPECT_EQ(f.twist(1ms, {{std::numeric_limits<double>::quiet_NaN(), 0, 0}, {}}), InputFault::malformed);
    EXPECT_EQ(f.twist(1ms, {{}, {0, 0, std::numeric_limits<double>::infinity()}}), InputFault::malformed);
}

TEST(VelocityControl, nothing_is_sent_unless_the_mode_is_known_and_follows_velocities) {
    Flying f;
    EXPECT_EQ(f.twist(0ms), InputFault::unknown_mode);
    f.mode(0ms, attitude);
    EXPECT_EQ(f.twist(1ms), InputFault::wrong_mode);
    f.mode(2ms);
    EXPECT_EQ(f.twist(3ms), InputFault::none);
    EXPECT_EQ(f.twist(2003ms), InputFault::unknown_mode);    // no 0x06 for 2 s
}

TEST(VelocityControl, after_half_a_second_of_silence_it_stops_the_device_once) {
    Flying f;
    f.mode(0ms);
    EXPECT_FALSE(f.time(0ms));
    f.twist(1ms);
    EXPECT_EQ(f.control.due(), f.start + 501ms);
    EXPECT_FALSE(f.time(500ms));
    EXPECT_EQ(f.time(501ms), (VelocityFrame{425, 0, 0, 0, 0}));
    EXPECT_FALSE(f.time(502ms));
    EXPECT_FALSE(f.control.due());
    EXPECT_FALSE(f.time(10s));
}

TEST(VelocityControl, it_does_not_stop_a_device_whose_mode_changed_for_there_the_throttle_counts) {
    Flying f;
    f.mode(0ms);
    f.twist(1ms);
    f.mode(100ms, attitude);
    EXPECT_FALSE(f.time(501ms));
    f.mode(600ms);
    EXPECT_FALSE(f.time(601ms));
}

TEST(VelocityControl, several_modes_may_follow_velocities) {
    VelocityControl control{50'000, {2, 7}};
    VelocityFrame frame;
    const ano::TimePoint now{5s};
    control.on_mode(7, now);
    EXPECT_EQ(control.on_twist({}, now, frame), InputFault::none);
    EXPECT_EQ(frame.throttle, 500);
}

}    // namespace
}    // namespace velocity_control_tests
