#include <ano/attitude.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <support/bytes.hpp>

namespace attitude_tests {
namespace {

using namespace ano;

void expect_same(const Rotation& a, const Rotation& b) { EXPECT_NEAR(degrees_between(a, b), 0, 1e-4); }

TEST(Attitude, of_euler_angles_turns_about_x_then_y_then_z) {
    const double half = std::sqrt(0.5);
    expect_same(rotation_of_euler(90, 0, 0, EulerSigns::document), {half, half, 0, 0});
    expect_same(rotation_of_euler(0, 90, 0, EulerSigns::document), {half, 0, half, 0});
    expect_same(rotation_of_euler(0, 0, 90, EulerSigns::document), {half, 0, 0, half});
    expect_same(rotation_of_euler(90, 0, 90, EulerSigns::document), {0.5, 0.5, 0.5, 0.5});
}

TEST(Attitude, of_lx_units_has_inverted_pitch_and_yaw) {
    expect_same(rotation_of_euler(20, -30, 40, EulerSigns::lx), rotation_of_euler(20, 30, -40, EulerSigns::document));
    EXPECT_GT(
        degrees_between(rotation_of_euler(20, -30, 40, EulerSigns::lx), rotation_of_euler(20, -30, 40, EulerSigns::document)),
        60);
}

TEST(Attitude, of_a_quaternion_is_normalised_or_rejected) {
    EXPECT_FALSE(rotation_of_quaternion(0, 0, 0, 0));
    EXPECT_FALSE(rotation_of_quaternion(1, 1, 0, 0));
    EXPECT_FALSE(rotation_of_quaternion(std::nan(""), 0, 0, 0));
    EXPECT_NEAR(rotation_of_quaternion(0.95, 0, 0, 0)->w, 1, 1e-12);
}

TEST(Attitude, of_a_frame_is_read_from_every_layout) {
    const auto euler = support::frame(0xDD, 0xFE, 0x03, {0, 0, 0, 0, 0x28, 0x23, 1});    // yaw 90
    const auto with_mode = support::frame(0xDD, 0xFE, 0x03, {1, 0, 0, 0, 0, 0x28, 0x23, 1});
    const auto quaternion = support::frame(0xDD, 0xFE, 0x04, {0x9F, 0x1B, 0, 0, 0, 0, 0x61, 0xE4, 1});    // yaw -90
    const auto of = [](const support::Bytes& bytes, EulerSigns signs) { return rotation_of(FrameView{bytes}, signs).value(); };
    expect_same(of(euler, EulerSigns::document), of(with_mode, EulerSigns::document));
    EXPECT_NEAR(degrees_between(of(euler, EulerSigns::document), of(quaternion, EulerSigns::document)), 180, 1e-3);
    EXPECT_NEAR(degrees_between(of(euler, EulerSigns::lx), of(quaternion, EulerSigns::lx)), 0, 1e-3);
    const auto other = support::frame(0xDD, 0xFE, 0x01, support::Bytes(13));
    EXPECT_FALSE(rotation_of(FrameView{other}, EulerSigns::lx));
    const auto unknown = support::frame(0xDD, 0xFE, 0x03, support::Bytes(9));
    EXPECT_FALSE(rotation_of(FrameView{unknown}, EulerSigns::document));
}

}    // namespace
}    // namespace attitude_tests
