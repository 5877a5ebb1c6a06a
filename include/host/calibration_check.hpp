// Whether a device uses the calibration that was stored in it: its new samples must be as good as the fit predicts.
#pragma once
#include <host/compass_fit.hpp>

#include <bitset>
#include <cstddef>
#include <optional>
#include <vector>

namespace ano::host {

/// The faces that show whether a device uses its calibration, in the order in which it must lie on them. It already lies on
/// `last`, which shows its offsets and the sensitivity of one axis. Another face is added only for a device whose mistake that
/// face does not show: it divides by the sensitivity, leaves out the error matrix (if errors are measured by direction), or had
/// corrected `faces` with its `old` calibration.
std::vector<Face> faces_that_prove(const AccelerometerCalibration& calibration, const AccelerometerCalibration& old,
                                   const SixFaces& faces, Face last);

/// The check on one face. Samples are judged in groups, so that samples from before the device used its calibration, or from
/// while it was moved, don't matter: the first good group is enough.
class AccelerometerCheck {
public:
    static constexpr std::size_t group = SixFaces::enough;    // still samples
    static constexpr double resolution = 2;                   // cm/s²: integers on three axes, rounded twice
    static constexpr double times_promised = 3;

    /// `promised`: the error of the fit on this face, cm/s².
    AccelerometerCheck(Face face, double promised, Measure measure) noexcept
        : face_{face}, promised_{promised}, measure_{measure} {}

    void add(const Vector& acceleration, const Vector& rotation) noexcept;
    /// cm/s², of the last group; std::nullopt before the first.
    std::optional<double> error() const noexcept { return error_; }
    bool is_passed() const noexcept { return error_ && *error_ <= limit(promised_) + noise_; }
    Face face() const noexcept { return face_; }
    double promised() const noexcept { return promised_; }
    /// cm/s², without the noise of the samples.
    static constexpr double limit(double promised) noexcept { return times_promised * promised + resolution; }
    /// cm/s², the largest difference of two residuals over all faces that rounding explains.
    static constexpr double margin = resolution / 2;

private:
    Face face_;
    double promised_;
    Measure measure_;
    double noise_ = 0;    // cm/s², three times the standard error of the last group
    SixFaces samples_;
    std::optional<double> error_;
};

/// The same check in groups of samples from several directions.
class CompassCheck {
public:
    static constexpr std::size_t group = 24, cells = 12;    // samples, and the number of cells of the sphere that they must cover
    static constexpr double times_promised = 2;             // both are of single samples, with their noise
    static constexpr double tolerance = 0.01;               // as a share of the field

    /// `strength` and `promised`: of the fit, see CompassSphere::strength() and CompassSphere::fit().
    CompassCheck(double strength, double promised) noexcept : strength_{strength}, promised_{promised} {}

    void add(const Vector& field) noexcept;
    /// As a share of the field.
    std::optional<double> error() const noexcept { return error_; }
    bool is_passed() const noexcept { return error_ && *error_ <= limit(promised_); }
    double promised() const noexcept { return promised_; }
    /// As a share of the field.
    static constexpr double limit(double promised) noexcept { return times_promised * promised + tolerance; }
    /// As a share of the field, the largest difference of two residuals over the sphere that noise explains.
    static constexpr double margin = tolerance / 4;

private:
    double strength_;
    double promised_;
    std::bitset<CompassSphere::cells> covered_;
    std::size_t samples_ = 0;
    double squares_ = 0;
    std::optional<double> error_;
};

}    // namespace ano::host
