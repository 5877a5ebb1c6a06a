// Euler angles that contradict the quaternion, in simulated time.
#include <ano/typed.hpp>
#include <gateway/attitude_watch.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include <support/allocations.hpp>
#include <support/bytes.hpp>

namespace anogate::attitude_watch_tests {
namespace {

using namespace std::chrono_literals;
using ano::EulerSigns;
using support::Bytes;

template <class Draft>
Bytes encoded(const Draft& draft, std::uint8_t source) {
    Bytes bytes(64);
    bytes.resize(draft.encode(bytes, source, 0xFE));
    return bytes;
}

Bytes euler(double yaw, std::uint8_t source = 0xDD) {
    ano::Draft<"euler"> draft;
    EXPECT_TRUE(draft.set<"yaw">(yaw));
    return encoded(draft, source);
}

Bytes quaternion(double yaw, std::uint8_t source = 0xDD) {
    ano::Draft<"quaternion"> draft;
    EXPECT_TRUE(draft.set<"v0">(std::cos(yaw * std::numbers::pi / 360)));
    EXPECT_TRUE(draft.set<"v3">(std::sin(yaw * std::numbers::pi / 360)));
    return encoded(draft, source);
}

/// A device that sends both, 20 times a second.
struct Device {
    AttitudeWatch watch;
    ano::TimePoint now{1000s};

    void turn(ano::Duration time, double yaw_of_euler, double yaw_of_quaternion, std::uint8_t source = 0xDD) {
        for (const auto end = now + time; now < end; now += 50ms) {
            const Bytes one = euler(yaw_of_euler, source), other = quaternion(yaw_of_quaternion, source);
            watch.receive(ano::FrameView{one}, now);
            watch.receive(ano::FrameView{other}, now + 10ms);
        }
    }
};

TEST(AttitudeWatch, finds_a_contradiction_of_more_than_10_degrees_that_lasts_2_seconds) {
    Device device;
    device.turn(5s, 40, 49);
    EXPECT_EQ(device.watch.contradictory(), 0);
    device.turn(1900ms, 40, -40);
    EXPECT_EQ(device.watch.contradictory(), 0);
    device.turn(200ms, 40, -40);
    EXPECT_EQ(device.watch.contradictory(), 0xDD);
}

TEST(AttitudeWatch, ignores_a_short_contradiction) {
    Device device;
    for (int i = 0; i < 10; ++i) {
        device.turn(1500ms, 40, -40);
        device.turn(100ms, 40, 40);
    }
    EXPECT_EQ(device.watch.contradictory(), 0);
}

TEST(AttitudeWatch, finds_no_contradiction_with_the_right_setting) {
    Device device{.watch = AttitudeWatch{EulerSigns::lx}};
    device.turn(10s, 40, -40);
    EXPECT_EQ(device.watch.contradictory(), 0);
    device.turn(3s, 40, 40);
    EXPECT_EQ(device.watch.contradictory(), 0xDD);
    EXPECT_EQ(device.watch.signs(), EulerSigns::lx);
}

// The hint names the other setting, which must solve the contradiction: a quaternion in another order, or without fusion,
// contradicts both settings.
TEST(AttitudeWatch, ignores_a_contradiction_that_the_other_setting_does_not_solve) {
    Device device;
    device.turn(10s, 40, 100);
    device.turn(10s, 90, 0);
    EXPECT_EQ(device.watch.contradictory(), 0);
    device.turn(3s, 90, -90);
    EXPECT_EQ(device.watch.contradictory(), 0xDD);
}

TEST(AttitudeWatch, ignores_a_device_that_turns_far_between_the_two_frames) {
    Device device;
    for (int i = 0; i < 400; ++i, device.now += 50ms) {    // 200 degrees a second, the quaternion 90 ms late
        const Bytes one = euler(std::remainder(10.0 * i, 360)), other = quaternion(10.0 * i - 18);
        device.watch.receive(ano::FrameView{one}, device.now);
        device.watch.receive(ano::FrameView{other}, device.now + 1ms);
    }
    EXPECT_EQ(device.watch.contradictory(), 0);
}

TEST(AttitudeWatch, ignores_turns_through_180_degrees_and_the_other_sign_of_a_quaternion) {
    Device device;
    for (const double yaw : {179.0, -179.0, 180.0}) {
        device.turn(3s, yaw, yaw + 360);
        device.turn(3s, yaw, -360 + yaw);
    }
    EXPECT_EQ(device.watch.contradictory(), 0);
}

TEST(AttitudeWatch, ends_a_contradiction_when_both_agree_for_2_seconds) {
    Device device;
    device.turn(3s, 40, -40);
    device.turn(1900ms, 40, 40);
    EXPECT_EQ(device.watch.contradictory(), 0xDD);
    device.turn(200ms, 40, 40);
    EXPECT_EQ(device.watch.contradictory(), 0);
}

TEST(AttitudeWatch, frames_far_apart_and_of_different_devices_are_not_compared) {
    Device device;
    for (int i = 0; i < 40; ++i) {
        const Bytes one = euler(40), other = quaternion(-40), of_another = quaternion(-40, 0xDC);
        device.watch.receive(ano::FrameView{one}, device.now);
        device.watch.receive(ano::FrameView{of_another}, device.now);
        device.watch.receive(ano::FrameView{other}, device.now + 150ms);
        device.now += 300ms;
    }
    EXPECT_EQ(device.watch.contradictory(), 0);
}

TEST(AttitudeWatch, a_device_that_falls_silent_is_forgotten_and_makes_room_for_another) {
    Device device;
    for (std::uint8_t source = 1; source <= AttitudeWatch::max_devices; ++source) device.turn(50ms, 0, 0, source);
    device.turn(3s, 40, -40);
    EXPECT_EQ(device.watch.contradictory(), 0) << "no room";
    device.turn(12s, 40, -40);
    EXPECT_EQ(device.watch.contradictory(), 0xDD);
    device.turn(9s, 0, 0, 5);
    EXPECT_EQ(device.watch.contradictory(), 0xDD);
    device.turn(2s, 0, 0, 5);
    EXPECT_EQ(device.watch.contradictory(), 0);
}

TEST(AttitudeWatch, allocates_no_memory_and_compares_only_the_first_devices) {
    Device device;
    std::vector<Bytes> frames;
    for (std::uint8_t source = 1; source <= 40; ++source) {
        frames.push_back(euler(40, source));
        frames.push_back(quaternion(-40, source));
    }
    const auto before = support::allocations;
    for (int i = 0; i < 100; ++i, device.now += 50ms)
        for (const Bytes& frame : frames) device.watch.receive(ano::FrameView{frame}, device.now);
    EXPECT_EQ(support::allocations, before);
    EXPECT_EQ(device.watch.contradictory(), 1);
}

}    // namespace
}    // namespace anogate::attitude_watch_tests
