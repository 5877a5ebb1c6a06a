// Whether a device uses the calibration that was stored in it: fresh samples of it must be as good as the fit has promised.
#pragma once
#include <host/compass_fit.hpp>

#include <bitset>
#include <cstddef>
#include <optional>
#include <vector>

namespace ano::host {

/// The faces that show how a device uses its calibration, in the order in which it has to lie on them. `last`, on which it lies already,
/// shows its offsets and the sensitivity of one axis. Another one follows only if a device is not off there, but elsewhere, that divides by
/// the sensitivity, leaves out the error matrix (of faces that are measured by direction), or had corrected `faces` by its `old` calibration.
std::vector<Face> faces_that_prove(const AccelerometerCalibration& calibration, const AccelerometerCalibration& old,
                                   const SixFaces& faces, Face last);

/// On one face. Samples are judged in groups, so that those from before the device used its calibration, or while it was moved, do no
/// harm: the first good group is enough.
class AccelerometerCheck {
public:
    static constexpr std::size_t group = SixFaces::enough;    // still samples
    static constexpr double resolution = 2;                   // cm/s², of whole numbers on three axes, rounded twice
    static constexpr double times_promised = 3;

    /// `promised`: the error of the fit on this face, cm/s².
    AccelerometerCheck(Face face, double promised, Measure measure) noexcept
        : face_{face}, promised_{promised}, measure_{measure} {}

    void take(const Vector& acceleration, const Vector& rotation) noexcept;
    /// cm/s², of the last group; std::nullopt before the first.
    std::optional<double> error() const noexcept { return error_; }
    bool is_passed() const noexcept { return error_ && *error_ <= limit(promised_) + noise_; }
    Face face() const noexcept { return face_; }
    double promised() const noexcept { return promised_; }
    /// cm/s², without the noise of the samples.
    static constexpr double limit(double promised) noexcept { return times_promised * promised + resolution; }
    /// cm/s², by which two residuals over all faces may differ by rounding.
    static constexpr double margin = resolution / 2;

private:
    Face face_;
    double promised_;
    Measure measure_;
    double noise_ = 0;    // cm/s², three times the standard error of the last group
    SixFaces samples_;
    std::optional<double> error_;
};

/// The same in groups from several directions.
class CompassCheck {
public:
    static constexpr std::size_t group = 24, cells = 12;    // samples, and of how many cells of the sphere
    static constexpr double times_promised = 2;             // both are of single samples, with their noise
    static constexpr double tolerance = 0.01;               // as a share of the field

    /// `strength` and `promised`: of the fit, see CompassSphere::strength() and CompassSphere::fit().
    CompassCheck(double strength, double promised) noexcept : strength_{strength}, promised_{promised} {}

    void take(const Vector& field) noexcept;
    /// As a share of the field.
    std::optional<double> error() const noexcept { return error_; }
    bool is_passed() const noexcept { return error_ && *error_ <= limit(promised_); }
    double promised() const noexcept { return promised_; }
    /// As a share of the field.
    static constexpr double limit(double promised) noexcept { return times_promised * promised + tolerance; }
    /// As a share of the field, by which two residuals over the sphere may differ by noise.
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
