// Sends the attitude of a simulated device as 0x03 and 0x04.
#pragma once
#include "fill.hpp"
#include "noise.hpp"
#include "vector.hpp"

#include <ano/attitude.hpp>

namespace ano::world {

inline Draft<"euler"> euler_of(Angles is, EulerSigns signs, Noise& chance) noexcept {
    const double sign = signs == EulerSigns::lx ? -1 : 1;
    Draft<"euler"> draft;
    fill<"rol">(draft, is.roll / degree + 0.05 * chance.normal());
    fill<"pit">(draft, sign * is.pitch / degree + 0.05 * chance.normal());
    fill<"yaw">(draft, sign * is.yaw / degree);
    fill<"fusion_sta">(draft, 1);
    return draft;
}

inline Draft<"quaternion"> quaternion_of(const Attitude& is) noexcept {
    Draft<"quaternion"> draft;
    fill<"v0">(draft, is.w);
    fill<"v1">(draft, is.x);
    fill<"v2">(draft, is.y);
    fill<"v3">(draft, is.z);
    fill<"fusion_sta">(draft, 1);
    return draft;
}

}    // namespace ano::world
