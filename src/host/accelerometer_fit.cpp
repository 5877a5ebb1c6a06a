#include <host/accelerometer_fit.hpp>
#include <host/least_squares.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ano::host {
namespace {

constexpr Vector direction(std::size_t face) noexcept {
    Vector d{};
    d[face / 2] = face % 2 == 0 ? 1 : -1;
    return d;
}

// Text for people: "3.2".
std::string with_one_decimal(double number) {
    const auto tenths = static_cast<long long>(std::llround(number * 10));
    return std::to_string(tenths / 10) + '.' + std::to_string(std::abs(tenths) % 10);
}

bool has_plausible_matrix(const AccelerometerCalibration& c) noexcept {
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            if (!(std::abs(c.error[i][j] - (i == j ? 1 : 0)) < 0.2)) return false;
    return true;
}

// Values outside these bounds are not caused by a misaligned sensor but by faces that were held wrongly.
bool is_plausible(const AccelerometerCalibration& c) noexcept {
    for (std::size_t i = 0; i < 3; ++i)
        if (!(std::abs(c.offset[i]) < SixFaces::gravity / 2 && c.sensitivity[i] > 0.5 && c.sensitivity[i] < 2)) return false;
    return has_plausible_matrix(c);
}

}    // namespace

Vector AccelerometerCalibration::corrected(const Vector& raw) const noexcept {
    Vector result{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) result[i] += error[i][j] * sensitivity[j] * (raw[j] - offset[j]);
    return result;
}

Vector AccelerometerCalibration::raw_of(const Vector& corrected) const noexcept {
    LeastSquares<3> squares;
    for (std::size_t i = 0; i < 3; ++i)
        squares.add({error[i][0] * sensitivity[0], error[i][1] * sensitivity[1], error[i][2] * sensitivity[2]}, corrected[i]);
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const Vector raw = squares.solution().value_or(Vector{none, none, none});
    return {raw[0] + offset[0], raw[1] + offset[1], raw[2] + offset[2]};
}

std::array<float, 15> AccelerometerCalibration::values() const noexcept {
    std::array<float, 15> all{};
    for (std::size_t i = 0; i < 3; ++i) {
        all[i] = static_cast<float>(offset[i]);
        all[3 + i] = static_cast<float>(sensitivity[i]);
        for (std::size_t row = 0; row < 3; ++row) all[6 + 3 * row + i] = static_cast<float>(error[row][i]);
    }
    return all;
}

AccelerometerCalibration AccelerometerCalibration::of(const std::array<float, 15>& values) noexcept {
    AccelerometerCalibration c;
    for (std::size_t i = 0; i < 3; ++i) {
        c.offset[i] = double{values[i]};
        c.sensitivity[i] = double{values[3 + i]};
        for (std::size_t row = 0; row < 3; ++row) c.error[row][i] = double{values[6 + 3 * row + i]};
    }
    return c;
}

double error_on(Face face, const Vector& acceleration, Measure measure) noexcept {
    if (measure == Measure::length) return std::abs(length_of(acceleration) - SixFaces::gravity);
    const Vector d = direction(static_cast<std::size_t>(face));
    return length_of({acceleration[0] - SixFaces::gravity * d[0], acceleration[1] - SixFaces::gravity * d[1],
                      acceleration[2] - SixFaces::gravity * d[2]});
}

Vector SixFaces::mean(Face face) const noexcept {
    const Gathered& of = gathered_[static_cast<std::size_t>(face)];
    const auto n = static_cast<double>(of.count);
    return {(of.sum[0][0] + of.sum[1][0]) / n, (of.sum[0][1] + of.sum[1][1]) / n, (of.sum[0][2] + of.sum[1][2]) / n};
}

double SixFaces::spread(Face face) const noexcept {
    const Gathered& of = gathered_[static_cast<std::size_t>(face)];
    const Vector m = mean(face);
    const double variance = of.squares / static_cast<double>(of.count) - (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    return std::sqrt(std::max(0.0, variance));
}

void SixFaces::add(const Vector& acceleration, const Vector& rotation) noexcept {
    last_[taken_++ % window] = {acceleration, rotation};
    judge();
    if (!is_still() || !face_) return;
    Gathered& face = gathered_[static_cast<std::size_t>(*face_)];
    if (face.count >= enough) return;
    const bool is_early = face.count < enough / 2;
    Vector& sum = face.sum[face.count++ % 2];
    for (std::size_t i = 0; i < 3; ++i) {
        sum[i] += acceleration[i];
        if (is_early) face.first[i] += acceleration[i];
        face.squares += acceleration[i] * acceleration[i];
    }
    if (face.count < enough) return;
    face.was_turning = face.drifts(0) && face.turns();
    if (!face.drifts(drift)) return;
    const std::size_t swings = face.swings + (face.turns() ? 1 : 0);
    face = {};
    face.swings = swings;
}

// Whether the difference between earlier and later samples exceeds three times its standard error, plus `beyond`.
bool SixFaces::Gathered::drifts(double beyond) const noexcept {
    const double n = static_cast<double>(count), half = n / 2;
    double difference = 0, variance = squares / n;
    for (std::size_t i = 0; i < 3; ++i) {
        const double all = sum[0][i] + sum[1][i], d = (all - 2 * first[i]) / half;
        difference += d * d;
        variance -= all / n * (all / n);
    }
    variance -= difference / 4;    // the variance within each half
    return std::sqrt(difference) > 3 * std::sqrt(std::max(0.0, variance) * 2 / half) + beyond;
}

// Whether only the direction changes. If a device smooths its samples and still settles, the length changes too.
bool SixFaces::Gathered::turns() const noexcept {
    Vector later{}, turned{};
    for (std::size_t i = 0; i < 3; ++i) {
        later[i] = sum[0][i] + sum[1][i] - first[i];
        turned[i] = later[i] - first[i];
    }
    return length_of(turned) > 4 * std::abs(length_of(later) - length_of(first));
}

bool SixFaces::sways() const noexcept {
    const auto turning = std::count_if(gathered_.begin(), gathered_.end(), [](const Gathered& g) { return g.was_turning; });
    return turning > static_cast<std::ptrdiff_t>(max_turning) ||
           std::any_of(gathered_.begin(), gathered_.end(), [](const Gathered& g) { return g.swings > max_swings; });
}

void SixFaces::judge() noexcept {
    unrest_.reset();
    face_.reset();
    if (taken_ < window) return;
    const auto of = [&](auto member, std::size_t axis) {
        double sum = 0, squares = 0;
        for (const Sample& s : last_) sum += (s.*member)[axis];
        const double mean = sum / double{window};
        for (const Sample& s : last_) squares += ((s.*member)[axis] - mean) * ((s.*member)[axis] - mean);
        return std::pair{mean, std::sqrt(squares / double{window})};
    };
    Vector mean{};
    double unrest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [acceleration, shaking] = of(&Sample::acceleration, axis);
        mean[axis] = acceleration;
        unrest = std::max({unrest, shaking / still_acceleration, of(&Sample::rotation, axis).second / still_rotation});
    }
    unrest_ = unrest;
    const double length = length_of(mean);
    if (length < 0.5 * gravity || length > 1.5 * gravity) return;
    for (std::size_t face = 0; face < 6; ++face) {
        const Vector d = direction(face);
        if (mean[0] * d[0] + mean[1] * d[1] + mean[2] * d[2] > 0.9 * length) face_ = static_cast<Face>(face);
    }
}

std::size_t SixFaces::faces_done() const noexcept {
    return static_cast<std::size_t>(
        std::count_if(gathered_.begin(), gathered_.end(), [](const Gathered& g) { return g.count >= enough; }));
}

Vector SixFaces::Gathered::mean(std::size_t half) const noexcept {
    const std::size_t of_half = (count + 1 - half) / 2;
    const auto n = static_cast<double>(of_half);
    return {sum[half][0] / n, sum[half][1] / n, sum[half][2] / n};
}

// Each axis of the corrected vector is linear in the raw vector: M · raw + c, where M = E · diag(S) and c = −M · O. The diagonal
// of E is 1.
std::optional<AccelerometerCalibration> SixFaces::solve() const noexcept {
    std::array<Vector, 3> m{};
    Vector c{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        LeastSquares<4> squares;
        for (std::size_t face = 0; face < 6; ++face) {
            const Vector raw = gathered_[face].mean(0);
            squares.add({raw[0], raw[1], raw[2], gravity}, gravity * direction(face)[axis]);
        }
        const auto x = squares.solution();
        if (!x) return std::nullopt;
        m[axis] = {(*x)[0], (*x)[1], (*x)[2]};
        c[axis] = (*x)[3] * gravity;
    }
    LeastSquares<3> offset;
    for (std::size_t axis = 0; axis < 3; ++axis) offset.add(m[axis], -c[axis]);
    const auto o = offset.solution();
    if (!o) return std::nullopt;
    AccelerometerCalibration result;
    result.offset = *o;
    for (std::size_t j = 0; j < 3; ++j) {
        result.sensitivity[j] = m[j][j];
        for (std::size_t i = 0; i < 3; ++i) result.error[i][j] = m[i][j] / m[j][j];
    }
    return result;
}

// Solves only for offset and sensitivity, with the error matrix of `old`: Newton's method, since the length is not linear in
// them.
std::optional<AccelerometerCalibration> SixFaces::solve_by_length(const AccelerometerCalibration& old) const noexcept {
    auto result = solve();
    if (!result) return std::nullopt;
    result->error = has_plausible_matrix(old) ? old.error : AccelerometerCalibration{}.error;
    for (int round = 0; round < 8; ++round) {
        LeastSquares<6> squares;
        for (const Gathered& face : gathered_) {
            const Vector raw = face.mean(0), v = result->corrected(raw);
            LeastSquares<6>::Row row{};
            for (std::size_t j = 0; j < 3; ++j) {
                double along = 0;
                for (std::size_t i = 0; i < 3; ++i) along += v[i] / length_of(v) * result->error[i][j];
                row[j] = -along * result->sensitivity[j];
                row[3 + j] = along * (raw[j] - result->offset[j]) / gravity;
            }
            squares.add(row, gravity - length_of(v));
        }
        const auto x = squares.solution();
        if (!x) return std::nullopt;
        for (std::size_t j = 0; j < 3; ++j) {
            result->offset[j] += (*x)[j];
            result->sensitivity[j] += (*x)[3 + j] / gravity;
        }
    }
    return result;
}

Measure SixFaces::choose_measure(const AccelerometerCalibration& old) const noexcept {
    const auto with_new_matrix = is_complete() ? solve() : std::nullopt;
    const auto with_old_matrix = with_new_matrix ? solve_by_length(old) : std::nullopt;
    if (!with_old_matrix) return Measure::direction;    // fit() rejects it
    const auto by = [&](Measure measure, const AccelerometerCalibration& c, std::size_t half) {
        return residual_by(measure, c, half, {});
    };
    const double best = by(Measure::direction, *with_new_matrix, 0);
    const bool shows_it = !sways() && best <= level && clearly * best < by(Measure::direction, *with_old_matrix, 0);
    const bool is_worse = by(Measure::length, *with_new_matrix, 1) > by(Measure::length, old, 1) + drift;
    return shows_it && !is_worse ? Measure::direction : Measure::length;
}

double SixFaces::worst(const AccelerometerCalibration& calibration) const noexcept {
    double worst = 0;
    for (std::size_t i = 0; i < face_names.size(); ++i) {
        const auto face = static_cast<Face>(i);
        worst = std::max(worst, error_on(face, calibration.corrected(mean(face)), measure_));
    }
    return worst;
}

double SixFaces::residual(const AccelerometerCalibration& calibration, const AccelerometerCalibration& device) const noexcept {
    return residual_by(measure_, calibration, 1, device);
}

double SixFaces::residual_by(Measure measure, const AccelerometerCalibration& calibration, std::size_t half,
                             const AccelerometerCalibration& device) const noexcept {
    double squares = 0;
    for (std::size_t i = 0; i < face_names.size(); ++i) {
        const Vector corrected = calibration.corrected(device.raw_of(gathered_[i].mean(half)));
        const double off = error_on(static_cast<Face>(i), corrected, measure);
        squares += off * off;
    }
    return std::sqrt(squares / 6);
}

Fit<AccelerometerCalibration> SixFaces::fit(const AccelerometerCalibration& old) const {
    Fit<AccelerometerCalibration> result;
    if (!is_complete()) {
        result.wrong = {"faces_missing", faces_done()};
        return result;
    }
    const auto all = solve();
    const double tilt = all ? residual_by(Measure::direction, *all, 1, {}) : 0;
    const auto found = measure_ == Measure::direction ? all : solve_by_length(old);
    result.before = residual(old);
    result.after = found ? residual(*found) : 0;
    if (!found || !is_plausible(*all) || !is_plausible(*found)) result.wrong = {"faces_inconsistent"};
    else if (!(tilt < max_residual)) result.wrong = {"residual_too_large", with_one_decimal(tilt)};
    else if (result.after >= result.before)
        result.wrong = {"old_as_good", with_one_decimal(result.before), with_one_decimal(result.after)};
    else result.calibration = *found;
    return result;
}

}    // namespace ano::host
