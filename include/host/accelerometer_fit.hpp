// The calibration of an accelerometer from samples of its six faces.
#pragma once
#include <ano/fault.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ano::host {

using Vector = std::array<double, 3>;    // x, y, z
inline double length_of(const Vector& v) noexcept { return std::hypot(v[0], v[1], v[2]); }

/// corrected = E · diag(S) · (raw − O), in cm/s². The protocol text names the parameters but gives no formula; this one is anogate's.
struct AccelerometerCalibration {
    Vector offset{};
    Vector sensitivity{1, 1, 1};
    std::array<Vector, 3> error{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};    // rows

    Vector corrected(const Vector& raw) const noexcept;
    /// Not finite if `corrected` has no inverse.
    Vector raw_of(const Vector& corrected) const noexcept;
    /// In the order of its parameters (protocol text, section 4): CAL_AOFF_, CAL_ASEN_, CAL_AEM1_ to CAL_AEM3_, each X Y Z.
    std::array<float, 15> values() const noexcept;
    static AccelerometerCalibration of(const std::array<float, 15>& values) noexcept;
};

/// The result of a fit.
template <class Calibration>
struct Fit {
    std::optional<Calibration> calibration;    // std::nullopt: rejected, see `wrong`
    Fault wrong{};
    double before = 0, after = 0;    // the residuals with the old values and with the new ones
};

/// Named by the axis that measures gravity: at rest +x is the face on which x reads +980 cm/s².
enum class Face : std::uint8_t { x_plus, x_minus, y_plus, y_minus, z_plus, z_minus };
inline constexpr std::array<std::string_view, 6> face_names{"+x", "-x", "+y", "-y", "+z", "-z"};
constexpr std::string_view name_of(Face face) noexcept { return face_names[static_cast<std::size_t>(face)]; }

/// How an error is measured. `length`: by the length of the acceleration, which is that of gravity at any tilt; it shows offsets
/// and sensitivities. `direction`: by its direction too; it also shows the error matrix, but the faces must be level.
enum class Measure : std::uint8_t { length, direction };

/// cm/s², the difference between `acceleration` and gravity alone on `face`.
double error_on(Face face, const Vector& acceleration, Measure measure = Measure::direction) noexcept;

/// Collects samples of each face while the device lies still on it. Only fit() allocates, for its text.
class SixFaces {
public:
    static constexpr double gravity = 980.665;          // cm/s²
    static constexpr std::size_t enough = 60;           // samples that complete a face
    static constexpr std::size_t window = 20;           // samples by which stillness is judged
    static constexpr double still_acceleration = 15;    // cm/s², the maximum standard deviation of an axis
    static constexpr double still_rotation = 1.5;       // °/s, the same for rotation
    /// cm/s², the largest difference, beyond noise, between the later and the earlier samples of a face. With a larger one the
    /// face is measured again: the device is being tilted, or it smooths its samples and still settles.
    static constexpr double drift = 0.5;
    /// cm/s². With a larger residual the device did not lie level on its faces.
    static constexpr double max_residual = 0.05 * gravity;
    /// cm/s². Up to this residual the faces were level enough to show the error matrix: 0.17°.
    static constexpr double level = 0.003 * gravity;
    /// The factor by which a new error matrix must reduce the residual. With random tilts one calibration of fifty reaches it.
    static constexpr double clearly = 3.5;
    /// Limits for choose_measure(). Samples of a swaying device pass as still where it turns back, and then they don't show its
    /// tilt. A sway is assumed if one face was measured again more than `max_swings` times, or if more than `max_turning` faces
    /// were turning.
    static constexpr std::size_t max_swings = 3, max_turning = 1;

    /// Takes one sample, not calibrated: cm/s² and °/s (0x01).
    void add(const Vector& acceleration, const Vector& rotation) noexcept;

    /// How much the device moves: a value up to 1 counts as still; std::nullopt before the window is full.
    std::optional<double> unrest() const noexcept { return unrest_; }
    bool is_still() const noexcept { return unrest_ && *unrest_ <= 1; }
    /// The face that is up now; std::nullopt if the direction is not clear.
    std::optional<Face> face() const noexcept { return face_; }
    std::size_t samples(Face face) const noexcept { return gathered_[static_cast<std::size_t>(face)].count; }
    bool is_enough(Face face) const noexcept { return samples(face) >= enough; }
    /// The mean of the samples of a face, which must have at least one.
    Vector mean(Face face) const noexcept;
    /// cm/s², the standard deviation of these samples, over all axes.
    double spread(Face face) const noexcept;
    std::size_t faces_done() const noexcept;
    bool is_complete() const noexcept { return faces_done() == 6; }

    /// `direction` if the faces were level enough to show the error matrix, and show that the one of `old` is wrong. Otherwise
    /// `length`: fit() keeps the matrix of `old`.
    Measure choose_measure(const AccelerometerCalibration& old) const noexcept;
    void measure_by(Measure measure) noexcept { measure_ = measure; }
    Measure measure() const noexcept { return measure_; }
    /// Computed from one half of the samples and checked with the other half: rejected if the residual is not below that of
    /// `old`.
    Fit<AccelerometerCalibration> fit(const AccelerometerCalibration& old) const;
    /// cm/s², of one half of the samples; see fit(). `device`: the calibration with which the device has corrected them.
    double residual(const AccelerometerCalibration& calibration, const AccelerometerCalibration& device = {}) const noexcept;
    /// cm/s², the error on the face that is off most.
    double worst(const AccelerometerCalibration& calibration) const noexcept;

private:
    struct Sample {
        Vector acceleration{}, rotation{};
    };
    struct Gathered {
        std::size_t count = 0;
        double squares = 0;             // of the lengths
        std::array<Vector, 2> sum{};    // of the samples of each half: every second sample belongs to the other half
        Vector first{};                 // the sum of the earlier ones
        Vector mean(std::size_t half) const noexcept;
        bool drifts(double beyond) const noexcept;
        bool turns() const noexcept;
        std::size_t swings = 0;    // how often it was measured again because of that
        bool was_turning = false;
    };
    bool sways() const noexcept;

    void judge() noexcept;
    std::optional<AccelerometerCalibration> solve() const noexcept;
    std::optional<AccelerometerCalibration> solve_by_length(const AccelerometerCalibration& old) const noexcept;
    double residual_by(Measure measure, const AccelerometerCalibration& calibration, std::size_t half,
                       const AccelerometerCalibration& device) const noexcept;

    Measure measure_ = Measure::direction;
    std::array<Sample, window> last_{};
    std::size_t taken_ = 0;
    std::optional<double> unrest_;
    std::optional<Face> face_;
    std::array<Gathered, 6> gathered_{};
};

}    // namespace ano::host
