#include <host/calibration_check.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace ano::host {
namespace {

// Mistakes to detect: the device applies its calibration in another way than AccelerometerCalibration::corrected(), or its
// samples were not raw.
constexpr std::size_t mistakes = 3;

// The samples that the device sends with each mistake, where the measured value is `raw`.
std::array<Vector, mistakes> sent_by_mistake(const AccelerometerCalibration& right, const AccelerometerCalibration& old,
                                             const Vector& raw) noexcept {
    AccelerometerCalibration divides = right, without_matrix = right;
    for (double& factor : divides.sensitivity) factor = 1 / factor;
    without_matrix.error = AccelerometerCalibration{}.error;
    return {divides.corrected(raw), without_matrix.corrected(raw), right.corrected(old.raw_of(raw))};
}

// Whether this face shows the mistake. The threshold is twice the limit, so that neither noise nor the residual hides it.
double how_clear(const Vector& as_right, const Vector& as_wrong, Face face, Measure measure) {
    const double off = measure == Measure::length
                           ? std::abs(length_of(as_wrong) - length_of(as_right))
                           : length_of({as_wrong[0] - as_right[0], as_wrong[1] - as_right[1], as_wrong[2] - as_right[2]});
    return off / (2 * AccelerometerCheck::limit(error_on(face, as_right, measure)));
}

}    // namespace

std::vector<Face> faces_that_prove(const AccelerometerCalibration& calibration, const AccelerometerCalibration& old,
                                   const SixFaces& faces, Face last) {
    std::vector<Face> chosen{last};
    for (std::size_t mistake = 0; mistake < mistakes; ++mistake) {
        const auto clear = [&](Face face) {
            const Vector raw = faces.mean(face);
            return how_clear(calibration.corrected(raw), sent_by_mistake(calibration, old, raw)[mistake], face, faces.measure());
        };
        if (std::any_of(chosen.begin(), chosen.end(), [&](Face face) { return clear(face) > 1; })) continue;
        Face best = last;
        for (std::size_t i = 0; i < face_names.size(); ++i)
            if (clear(static_cast<Face>(i)) > clear(best)) best = static_cast<Face>(i);
        if (clear(best) > 1) chosen.push_back(best);
    }
    return chosen;
}

void AccelerometerCheck::add(const Vector& acceleration, const Vector& rotation) noexcept {
    samples_.add(acceleration, rotation);
    if (samples_.samples(face_) < group) return;
    error_ = error_on(face_, samples_.mean(face_), measure_);
    noise_ = 3 * samples_.spread(face_) / std::sqrt(static_cast<double>(group));
    samples_ = {};
}

void CompassCheck::add(const Vector& field) noexcept {
    covered_.set(CompassSphere::cell_of(field));
    const double off = std::hypot(field[0], field[1], field[2]) / strength_ - 1;
    squares_ += off * off;
    ++samples_;
    if (samples_ < group || covered_.count() < cells) return;
    error_ = std::sqrt(squares_ / static_cast<double>(samples_));
    covered_.reset();
    samples_ = 0;
    squares_ = 0;
}

}    // namespace ano::host
