// Orientations from Euler angles (0x03) and quaternions (0x04).
#pragma once
#include <ano/frame.hpp>

#include <cstdint>
#include <optional>

namespace ano {

/// The signs of the Euler angles that a device sends. In both cases its quaternion uses the axes x forward, y to the left and z
/// up, right-handed.
enum class EulerSigns : std::uint8_t {
    document,    // as those of its quaternion
    lx,          // pitch and yaw have the opposite sign, as on the vendor's LX units
};

/// A unit quaternion: turns a vector from the axes of the device to those of the ground.
struct Rotation {
    double w = 1, x = 0, y = 0, z = 0;
};

/// From roll, pitch and yaw in degrees, as the device sends them.
Rotation rotation_of_euler(double roll, double pitch, double yaw, EulerSigns signs) noexcept;
/// Normalised. std::nullopt: its length is not near 1. Devices without an orientation send zeros.
std::optional<Rotation> rotation_of_quaternion(double v0, double v1, double v2, double v3) noexcept;
/// The same for a frame, in any layout with Euler angles or a quaternion; std::nullopt: another message.
std::optional<Rotation> rotation_of(FrameView frame, EulerSigns signs) noexcept;

/// The angle of the rotation from one to the other, 0 to 180 degrees.
double degrees_between(const Rotation& a, const Rotation& b) noexcept;

}    // namespace ano
