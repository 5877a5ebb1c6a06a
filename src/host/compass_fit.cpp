#include <host/compass_fit.hpp>
#include <host/least_squares.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ano::host {
namespace {

// Text for people: "3.2 %".
std::string percent(double share) {
    const auto tenths = static_cast<long long>(std::llround(share * 1000));
    return std::to_string(tenths / 10) + '.' + std::to_string(tenths % 10) + " %";
}

}    // namespace

Vector CompassCalibration::corrected(const Vector& raw) const noexcept {
    return {sensitivity[0] * (raw[0] - offset[0]), sensitivity[1] * (raw[1] - offset[1]), sensitivity[2] * (raw[2] - offset[2])};
}

Vector CompassCalibration::raw_of(const Vector& v) const noexcept {
    return {v[0] / sensitivity[0] + offset[0], v[1] / sensitivity[1] + offset[1], v[2] / sensitivity[2] + offset[2]};
}

std::array<float, 6> CompassCalibration::values() const noexcept {
    std::array<float, 6> all{};
    for (std::size_t i = 0; i < 3; ++i) {
        all[i] = static_cast<float>(offset[i]);
        all[3 + i] = static_cast<float>(sensitivity[i]);
    }
    return all;
}

CompassCalibration CompassCalibration::of(const std::array<float, 6>& values) noexcept {
    CompassCalibration c;
    for (std::size_t i = 0; i < 3; ++i) {
        c.offset[i] = double{values[i]};
        c.sensitivity[i] = double{values[3 + i]};
    }
    return c;
}

std::size_t CompassSphere::cell_of(const Vector& v) noexcept {
    const double length = std::max(length_of(v), 1e-9);
    const double up = (v[2] / length + 1) / 2;
    const double round = (std::atan2(v[1], v[0]) / std::numbers::pi + 1) / 2;
    const auto band = std::min(static_cast<std::size_t>(up * double{bands}), bands - 1);
    return band * sectors + std::min(static_cast<std::size_t>(round * double{sectors}), sectors - 1);
}

void CompassSphere::add(const Vector& raw) {
    bool moved = samples_.empty();
    if (moved) min_ = max_ = raw;
    for (std::size_t i = 0; i < 3; ++i) {
        moved = moved || raw[i] < min_[i] || raw[i] > max_[i];
        min_[i] = std::min(min_[i], raw[i]);
        max_[i] = std::max(max_[i], raw[i]);
    }
    if (moved) {
        for (std::size_t i = 0; i < 3; ++i) centre_[i] = (min_[i] + max_[i]) / 2;
        cover_again();
    }
    const std::size_t cell = cell_of({raw[0] - centre_[0], raw[1] - centre_[1], raw[2] - centre_[2]});
    if (in_cell_[cell] >= max_in_cell && !moved) return;
    if (samples_.size() >= 4 * cells * max_in_cell) return;
    samples_.push_back(raw);
    ++in_cell_[cell];
    covered_.set(cell);
}

void CompassSphere::cover_again() {
    covered_.reset();
    in_cell_.fill(0);
    for (const Vector& s : samples_) {
        const std::size_t cell = cell_of({s[0] - centre_[0], s[1] - centre_[1], s[2] - centre_[2]});
        ++in_cell_[cell];
        covered_.set(cell);
    }
}

// A x² + B y² + C z² + D x + E y + F z = 1 about the centre, in units of the half width, so that all unknowns have a similar
// size.
std::optional<CompassCalibration> CompassSphere::solve() const noexcept {
    const double unit = std::max({max_[0] - min_[0], max_[1] - min_[1], max_[2] - min_[2]}) / 2;
    if (!(unit > 0)) return std::nullopt;
    LeastSquares<6> squares;
    for (std::size_t i = 0; i < samples_.size(); i += 2) {
        Vector v{};
        for (std::size_t k = 0; k < 3; ++k) v[k] = (samples_[i][k] - centre_[k]) / unit;
        squares.add({v[0] * v[0], v[1] * v[1], v[2] * v[2], v[0], v[1], v[2]}, 1);
    }
    const auto x = squares.solution();
    if (!x) return std::nullopt;
    double scale = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!((*x)[k] > 0)) return std::nullopt;
        scale += (*x)[3 + k] * (*x)[3 + k] / (4 * (*x)[k]);
    }
    Vector radius{};
    CompassCalibration result;
    for (std::size_t k = 0; k < 3; ++k) {
        result.offset[k] = centre_[k] - unit * (*x)[3 + k] / (2 * (*x)[k]);
        radius[k] = unit * std::sqrt(scale / (*x)[k]);
    }
    const double mean = std::cbrt(radius[0] * radius[1] * radius[2]);
    for (std::size_t k = 0; k < 3; ++k) result.sensitivity[k] = mean / radius[k];
    return result;
}

double CompassSphere::strength(const CompassCalibration& calibration) const noexcept {
    double sum = 0;
    for (const Vector& sample : samples_) sum += length_of(calibration.corrected(sample));
    return samples_.empty() ? 0 : sum / static_cast<double>(samples_.size());
}

double CompassSphere::residual(const CompassCalibration& calibration, const CompassCalibration& device) const noexcept {
    double sum = 0, squares = 0, n = 0;
    for (std::size_t i = 1; i < samples_.size(); i += 2) {
        const double length = length_of(calibration.corrected(device.raw_of(samples_[i])));
        sum += length;
        squares += length * length;
        ++n;
    }
    const double mean = sum / n;
    return mean > 0 ? std::sqrt(std::max(squares / n - mean * mean, 0.0)) / mean : 1;
}

Fit<CompassCalibration> CompassSphere::fit(const CompassCalibration& old) const {
    Fit<CompassCalibration> result;
    if (!is_complete()) {
        result.wrong = {"directions_missing", percent(coverage())};
        return result;
    }
    const auto found = solve();
    result.before = residual(old);
    result.after = found ? residual(*found) : 1;
    if (!found || !(result.after < max_residual)) result.wrong = {"no_ellipsoid"};
    else if (result.after >= result.before) result.wrong = {"no_better", percent(result.after), percent(result.before)};
    else result.calibration = *found;
    return result;
}

}    // namespace ano::host
