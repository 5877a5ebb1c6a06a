// The walls around the origin of the world, for range finders.
#pragma once
#include "vector.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace ano::world {

inline constexpr double wall_ahead = 30, wall_aside = 20;    // m, from the origin, in both directions

/// The distance to the wall in metres, in `direction`: radians from the x axis to the left. 0 outside the walls.
inline double to_the_wall(Vector from, double direction) noexcept {
    if (std::abs(from.x) >= wall_ahead || std::abs(from.y) >= wall_aside) return 0;
    const double cos = std::cos(direction), sin = std::sin(direction);
    const double along = std::abs(cos) < 1e-9 ? 1e9 : (std::copysign(wall_ahead, cos) - from.x) / cos;
    const double aside = std::abs(sin) < 1e-9 ? 1e9 : (std::copysign(wall_aside, sin) - from.y) / sin;
    return std::min(along, aside);
}

/// A scan: angle (hundredths of a degree, clockwise from the nose) and distance (cm), every 10°.
using Scan = std::array<std::uint8_t, 36 * 4>;
Scan scan_from(Vector position, double yaw) noexcept;

}    // namespace ano::world
