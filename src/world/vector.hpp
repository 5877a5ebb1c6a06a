// Directions and attitudes. On the ground: x to the north, y to the west, z up, from the origin of the world. On a vehicle:
// x forward, y to the left, z up. Metres, seconds, radians.
#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>

namespace ano::world {

inline constexpr double gravity = 9.80665;    // m/s²
inline constexpr double degree = std::numbers::pi / 180;

struct Vector {
    double x = 0, y = 0, z = 0;

    friend constexpr Vector operator+(Vector a, Vector b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend constexpr Vector operator-(Vector a, Vector b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend constexpr Vector operator*(double k, Vector a) noexcept { return {k * a.x, k * a.y, k * a.z}; }
    friend constexpr bool operator==(Vector, Vector) = default;
    double length() const noexcept { return std::sqrt(x * x + y * y + z * z); }
};

constexpr Vector cross(Vector a, Vector b) noexcept {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// `v` shortened to `max_length` if it is longer.
inline Vector no_longer(Vector v, double max_length) noexcept {
    const double length = v.length();
    return length > max_length ? (max_length / length) * v : v;
}

/// The same angle in the range -pi to pi.
inline double wrapped(double angle) noexcept { return std::remainder(angle, 2 * std::numbers::pi); }

/// Roll leans to the right, pitch lowers the nose, yaw turns to the left.
struct Angles {
    double roll = 0, pitch = 0, yaw = 0;
};

/// A unit quaternion: rotates from the axes of the vehicle to those of the ground.
struct Attitude {
    double w = 1, x = 0, y = 0, z = 0;

    static Attitude of(Angles a) noexcept {
        const double cr = std::cos(a.roll / 2), sr = std::sin(a.roll / 2), cp = std::cos(a.pitch / 2), sp = std::sin(a.pitch / 2);
        const double cy = std::cos(a.yaw / 2), sy = std::sin(a.yaw / 2);
        return {cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
                cr * cp * sy - sr * sp * cy};
    }
    Angles angles() const noexcept {
        return {std::atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), std::asin(std::clamp(2 * (w * y - z * x), -1.0, 1.0)),
                std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))};
    }
    Attitude inverse() const noexcept { return {w, -x, -y, -z}; }
    Vector turn(Vector v) const noexcept {
        const Vector q{x, y, z};
        const Vector t = 2 * cross(q, v);
        return v + w * t + cross(q, t);
    }
    /// The attitude after a rotation with `rate` (in the axes of the vehicle) for `dt`.
    Attitude turned(Vector rate, double dt) const noexcept {
        const Vector h = (dt / 2) * rate;
        Attitude q{w - x * h.x - y * h.y - z * h.z, x + w * h.x + y * h.z - z * h.y, y + w * h.y + z * h.x - x * h.z,
                   z + w * h.z + x * h.y - y * h.x};
        const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
        return {q.w / length, q.x / length, q.y / length, q.z / length};
    }
};

}    // namespace ano::world
