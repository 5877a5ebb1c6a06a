// Uncalibrated sensors: with noise, an offset, a scale error and axes that are not quite perpendicular. A calibration finds all
// of these.
#pragma once
#include "noise.hpp"
#include "vector.hpp"

#include <array>

namespace ano::world {

/// cm/s². corrected = E · diag(S) · (raw − O), with the parameters CAL_AOFF_X to CAL_AEM3_Z.
class Accelerometer {
public:
    static constexpr double noise = 3;    // cm/s²

    explicit Accelerometer(Noise& chance) noexcept;
    /// `felt`: the true acceleration, m/s².
    Vector measure(Vector felt, Noise& chance) const noexcept;
    Vector corrected(Vector raw) const noexcept;

    std::array<float, 15> calibration{0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};

private:
    Vector offset_;
    std::array<Vector, 3> rows_;
};

/// In a unit in which the magnetic field of the Earth is 500. corrected = diag(S) · (raw − O), with the parameters CAL_MOFF_X to
/// CAL_MSEN_Z.
class Compass {
public:
    static constexpr double noise = 2;
    static constexpr Vector earth{300, 0, -400};    // to the north and down

    explicit Compass(Noise& chance) noexcept;
    Vector measure(const Attitude& attitude, Noise& chance) const noexcept;
    Vector corrected(Vector raw) const noexcept;

    std::array<float, 6> calibration{0, 0, 0, 1, 1, 1};

private:
    Vector offset_, scale_;
};

/// Measures in °/s.
class Gyroscope {
public:
    explicit Gyroscope(Noise& chance) noexcept : offset_{chance.within(0.2), chance.within(0.2), chance.within(0.2)} {}
    /// `rates`: the true rotation, rad/s.
    Vector measure(Vector rates, Noise& chance) const noexcept;

private:
    Vector offset_;
};

}    // namespace ano::world
