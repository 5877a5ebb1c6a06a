#include "sensors.hpp"

namespace ano::world {
namespace {

Vector within(Noise& chance, double max) noexcept { return {chance.within(max), chance.within(max), chance.within(max)}; }
Vector normal(Noise& chance, double deviation) noexcept {
    return deviation * Vector{chance.normal(), chance.normal(), chance.normal()};
}
double dot(Vector a, Vector b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <std::size_t N>
Vector three_of(const std::array<float, N>& values, std::size_t first) noexcept {
    return {double{values[first]}, double{values[first + 1]}, double{values[first + 2]}};
}
Vector each_times(Vector a, Vector b) noexcept { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

}    // namespace

Accelerometer::Accelerometer(Noise& chance) noexcept : offset_{within(chance, 30)}, rows_{} {
    const std::array<Vector, 3> exact{Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}};
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i] = exact[i] + within(chance, 0.02);
}

Vector Accelerometer::measure(Vector felt, Noise& chance) const noexcept {
    const Vector cm = 100 * felt;
    return Vector{dot(rows_[0], cm), dot(rows_[1], cm), dot(rows_[2], cm)} + offset_ + normal(chance, noise);
}

Vector Accelerometer::corrected(Vector raw) const noexcept {
    const Vector scaled = each_times(three_of(calibration, 3), raw - three_of(calibration, 0));
    return {dot(three_of(calibration, 6), scaled), dot(three_of(calibration, 9), scaled), dot(three_of(calibration, 12), scaled)};
}

Compass::Compass(Noise& chance) noexcept : offset_{within(chance, 80)}, scale_{Vector{1, 1, 1} + within(chance, 0.1)} {}

Vector Compass::measure(const Attitude& attitude, Noise& chance) const noexcept {
    return each_times(scale_, attitude.inverse().turn(earth)) + offset_ + normal(chance, noise);
}

Vector Compass::corrected(Vector raw) const noexcept {
    return each_times(three_of(calibration, 3), raw - three_of(calibration, 0));
}

Vector Gyroscope::measure(Vector rates, Noise& chance) const noexcept {
    return (1 / degree) * rates + offset_ + normal(chance, 0.1);
}

}    // namespace ano::world
