// The calibration of an accelerometer from its six faces.
#pragma once
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
    /// Not finite where nothing can be computed back.
    Vector raw_of(const Vector& corrected) const noexcept;
    /// In the order of its parameters (protocol text, section 4): CAL_AOFF_, CAL_ASEN_, CAL_AEM1_ to CAL_AEM3_, each X Y Z.
    std::array<float, 15> values() const noexcept;
    static AccelerometerCalibration of(const std::array<float, 15>& values) noexcept;
};

/// The result of a fit.
template <class Calibration>
struct Fit {
    std::optional<Calibration> calibration;    // std::nullopt: rejected, see `wrong`
    std::string wrong{};
    double before = 0, after = 0;    // the residuals with the old values and with the new ones
};

/// By the axis that measures gravity: at rest +x is the face on which x reads +980 cm/s².
enum class Face : std::uint8_t { x_plus, x_minus, y_plus, y_minus, z_plus, z_minus };
inline constexpr std::array<std::string_view, 6> face_names{"+x", "-x", "+y", "-y", "+z", "-z"};
constexpr std::string_view name_of(Face face) noexcept { return face_names[static_cast<std::size_t>(face)]; }

/// How an error is measured. By the length of an acceleration, which is that of gravity however the device is tilted, and shows offsets and
/// sensitivities; or by its direction too, which shows the error matrix, but needs faces that are level.
enum class Measure : std::uint8_t { length, direction };

/// cm/s², how far `acceleration` is from gravity alone on `face`.
double error_on(Face face, const Vector& acceleration, Measure measure = Measure::direction) noexcept;

/// Gathers samples of each face while the device lies still on it. Only fit() allocates, for its text.
class SixFaces {
public:
    static constexpr double gravity = 980.665;          // cm/s²
    static constexpr std::size_t enough = 60;           // samples that complete a face
    static constexpr std::size_t window = 20;           // samples by which stillness is judged
    static constexpr double still_acceleration = 15;    // cm/s², the maximum standard deviation of an axis
    static constexpr double still_rotation = 1.5;       // °/s, the same for rotation
    /// cm/s², by which the later samples of a face may differ from the earlier ones, beside their noise: else it is measured again. A device
    /// that smooths its samples still settles, or it is being tilted.
    static constexpr double drift = 0.5;
    /// cm/s². A larger residual means that the device did not lie level on its faces.
    static constexpr double max_residual = 0.05 * gravity;
    /// cm/s². Up to this residual the faces were level enough to show the error matrix: 0.17°.
    static constexpr double level = 0.003 * gravity;
    /// So many times smaller must the residual get by a new error matrix: with random tilts it does so in one calibration of fifty.
    static constexpr double clearly = 3.5;
    /// A device that is swaying is measured when it is about to turn back, where nothing shows how far it is tilted: but one of its faces
    /// was measured again more often than that, or two were turning.
    static constexpr std::size_t max_swings = 3, max_turning = 1;

    /// One sample, not calibrated: cm/s² and °/s (0x01).
    void take(const Vector& acceleration, const Vector& rotation) noexcept;

    /// How much the device moves: up to 1 counts as still; std::nullopt before the window is full.
    std::optional<double> unrest() const noexcept { return unrest_; }
    bool is_still() const noexcept { return unrest_ && *unrest_ <= 1; }
    /// The face that is up now; std::nullopt when none clearly is.
    std::optional<Face> face() const noexcept { return face_; }
    std::size_t samples(Face face) const noexcept { return gathered_[static_cast<std::size_t>(face)].count; }
    bool is_enough(Face face) const noexcept { return samples(face) >= enough; }
    /// The mean of the samples of a face, which must have some.
    Vector mean(Face face) const noexcept;
    /// cm/s², the standard deviation of these samples, of all axes together.
    double spread(Face face) const noexcept;
    std::size_t faces_done() const noexcept;
    bool is_complete() const noexcept { return faces_done() == 6; }

    /// Whether the faces show the error matrix, and show that `old` has a wrong one. Otherwise fit() keeps that of `old`, and errors are
    /// measured by length.
    Measure choose_measure(const AccelerometerCalibration& old) const noexcept;
    void measure_by(Measure measure) noexcept { measure_ = measure; }
    Measure measure() const noexcept { return measure_; }
    /// Computed from one half of the samples and checked with the other half: rejected when the residual is not below that of `old`.
    Fit<AccelerometerCalibration> fit(const AccelerometerCalibration& old) const;
    /// cm/s², of one half of the samples; see fit(). `device`: by which the device has corrected them.
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
        std::array<Vector, 2> sum{};    // of the samples of each half: every second one belongs to the other
        Vector first{};                 // the sum of the earlier ones
        Vector mean(std::size_t half) const noexcept;
        bool drifts(double beyond) const noexcept;
        bool turns() const noexcept;
        std::size_t swings = 0;    // so often it was measured again because of that
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
