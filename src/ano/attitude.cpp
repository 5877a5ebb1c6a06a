#include <ano/attitude.hpp>
#include <ano/typed.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ano {
namespace {

constexpr double radian = std::numbers::pi / 180;    // per degree

template <class View>
Rotation rotation_of_euler(const View& view, EulerSigns signs) noexcept {
    return rotation_of_euler(view.template get<"rol">(), view.template get<"pit">(), view.template get<"yaw">(), signs);
}

}    // namespace

// Rotates about x, then y, then z.
Rotation rotation_of_euler(double roll, double pitch, double yaw, EulerSigns signs) noexcept {
    const double sign = signs == EulerSigns::lx ? -1 : 1;
    const double r = radian * roll / 2, p = sign * radian * pitch / 2, y = sign * radian * yaw / 2;
    const double cr = std::cos(r), sr = std::sin(r), cp = std::cos(p), sp = std::sin(p), cy = std::cos(y), sy = std::sin(y);
    return {cy * cp * cr + sy * sp * sr, cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr};
}

std::optional<Rotation> rotation_of_quaternion(double v0, double v1, double v2, double v3) noexcept {
    const double length = std::sqrt(v0 * v0 + v1 * v1 + v2 * v2 + v3 * v3);
    if (!(length >= 0.9 && length <= 1.1)) return std::nullopt;
    return Rotation{v0 / length, v1 / length, v2 / length, v3 / length};
}

std::optional<Rotation> rotation_of(FrameView frame, EulerSigns signs) noexcept {
    if (const auto quaternion = as<"quaternion">(frame))
        return rotation_of_quaternion(quaternion->get<"v0">(), quaternion->get<"v1">(), quaternion->get<"v2">(),
                                      quaternion->get<"v3">());
    if (const auto euler = as<"euler">(frame)) return rotation_of_euler(*euler, signs);
    if (const auto euler = as<"euler", "field">(frame)) return rotation_of_euler(*euler, signs);
    return std::nullopt;
}

double degrees_between(const Rotation& a, const Rotation& b) noexcept {
    const double dot = std::abs(a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z);    // q and -q are the same
    return 2 * std::acos(std::min(dot, 1.0)) / radian;
}

}    // namespace ano
