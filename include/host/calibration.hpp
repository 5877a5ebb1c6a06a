// Calibrates the accelerometer or the compass of a device (protocol text, section 4: 0xE0 0x10 and the CAL_ parameters).
//
// Flow:    Calibration calibration{device, Sensor::accelerometer, &cache};
//          calibration.start(now);             // then drive the device, and pass every frame from it to calibration.hear()
//          if (calibration.step() == Calibration::Step::keep) { keep(calibration.old_values()); calibration.kept(now); }
//          calibration.faces(), calibration.sphere()     // to show while it is turned
#pragma once
#include <host/calibration_check.hpp>
#include <host/compass_fit.hpp>
#include <host/parameter_apply.hpp>
#include <host/restart_watch.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ano::host {

enum class Sensor : std::uint8_t { accelerometer, compass };

/// Names and values of calibration parameters, in their order.
using CalibrationValues = std::vector<std::pair<std::string, AnyValue>>;

/// The names of the parameters that a calibration of `sensor` writes: 15 or 6.
std::vector<std::string> calibration_names(Sensor sensor);
/// The values that correct nothing.
CalibrationValues neutral_calibration(Sensor sensor);
constexpr Sensor other_than(Sensor sensor) noexcept {
    return sensor == Sensor::accelerometer ? Sensor::compass : Sensor::accelerometer;
}
/// The calibration of `sensor` in parameters that were read; std::nullopt if one is missing.
std::optional<CalibrationValues> calibration_in(const Parameters& parameters, Sensor sensor);

/// A device that stores a calibration in thousandths, such as one with protocol V7, rounds its values by less than this.
inline constexpr double max_calibration_rounding = 0.001;
/// Whether a device that got `wanted` may have stored it as `has`.
bool may_be_stored_as(const AnyValue& wanted, const AnyValue& has) noexcept;

/// Writes all calibration values, sends the action that applies them, and reads them back.
class CalibrationWrite final : public Task {
public:
    CalibrationWrite(Device& device, DescriptionCache* cache, Sensor sensor, CalibrationValues values);

    void start(TimePoint now);
    Progress progress() const noexcept override { return apply_.progress(); }
    void cancel(TimePoint now) override;
    void ended(const Ended&, TimePoint) override {}    // only its sub-tasks send requests
    /// If it is done: as the device stored them.
    const CalibrationValues& values() const noexcept { return values_; }

private:
    void applied(TimePoint now);
    void on_use_ended(TimePoint now);
    void read_back(TimePoint now);

    CalibrationValues values_;
    ParameterApply apply_;
    ParameterAction use_;
    Parameters again_;
};

/// The old values are read, and the owner stores them before anything is changed. Then the device clears them, so that it sends
/// raw measurements, and the user turns it. The new values are computed, written and read back. After that, the corrected samples
/// of the device are compared with the residual of the fit, and the values are read once more, since the device may have
/// restarted before it stored them. If the new values are rejected, the task is cancelled or the device fails, the old values are
/// written back before the task ends. After a crash the owner writes them back with CalibrationWrite.
///
/// A device that restarts uses its old calibration again. So all samples are discarded, and the calibration is cleared again, in
/// these cases: a sign of a restart (RestartWatch) after the device acknowledged the clear; CAL_ parameters that differ, when the
/// device was turned to all sides, from those after the clear; samples that need no correction although the old values do correct
/// something, because the device corrected them already. If the last case occurs again after the next clear, the old values were
/// wrong, or the device ignores the clear.
///
/// A device whose CAL_ parameters correct nothing after the clear shows that it is cleared. If a device does not show that, each
/// of its samples may have been corrected. The new values are then checked on all sides (Step::prove): they must be better than
/// the old ones and leave almost nothing to correct.
class Calibration final : public Task {
public:
    enum class Step : std::uint8_t { read, keep, clear, turn, confirm, keep_new, write, verify, prove, restore, over };
    static constexpr Duration time_to_turn = std::chrono::minutes{10};
    static constexpr Duration time_to_verify = std::chrono::minutes{1};
    /// The task ends if the device sends nothing for this time, or no samples although it sends other frames.
    static constexpr Duration silent_after = std::chrono::milliseconds{4500};
    /// Samples may arrive this much later than answers, for example over a radio that sends answers first. Samples from before a
    /// clear or a store don't count.
    static constexpr Duration most_late = std::chrono::seconds{3};
    /// Accelerometer samples that follow one another sooner than this count as one, their mean: otherwise the samples of a fast
    /// device that is being turned would look still.
    static constexpr Duration spacing = std::chrono::milliseconds{15};
    /// The time for an answer while the old values are written back, when the device may already be silent.
    static constexpr Duration time_to_answer = std::chrono::milliseconds{400};
    static constexpr unsigned max_restarts = 5;    // of the device; the task ends after one more
    /// This many gaps in a row directly after the clear are not restarts: the task ends and reports them.
    static constexpr unsigned max_silences = 3;

    Calibration(Device& device, Sensor sensor, DescriptionCache* cache = nullptr);

    void start(TimePoint now);
    /// To be called when the owner has stored old_values(), in Step::keep_new new_values(), where they survive a crash.
    void kept(TimePoint now);
    /// In Step::keep_new: the new values could not be stored, so they are not written.
    void not_kept(const std::string& why, TimePoint now);
    /// Adds Step::keep_new to the flow.
    void keep_before_writing() noexcept { keeps_new_ = true; }
    /// Only in Step::keep: replaces the values to be written back, if those that were read are left over from an unfinished
    /// calibration.
    void set_old_values(CalibrationValues values);
    /// `refusal` is called directly before the new values are written. It returns the reason why that is not allowed; empty: it is
    /// allowed.
    void ask_before_writing(std::function<Fault()> refusal) { refusal_ = std::move(refusal); }
    /// To be called with every frame from the device's side, in addition to Device::take().
    void receive(FrameView frame, TimePoint now);
    /// When look() must be called, because a time-out ends; std::nullopt: not in this step.
    std::optional<TimePoint> due() const noexcept;
    void look(TimePoint now);
    /// The task ends after the old values are written back.
    void cancel(TimePoint now) override;
    /// Counts faces, or cells of the sphere.
    Progress progress() const noexcept override;
    void ended(const Ended&, TimePoint) override {}    // only its sub-tasks send requests

    Step step() const noexcept { return end() ? Step::over : step_; }
    const CalibrationValues& old_values() const noexcept { return old_; }
    /// The values of the other sensor, which are not changed: they distinguish units of one type. Empty: the device has none.
    const CalibrationValues& other_values() const noexcept { return other_; }
    /// The values of the device after the last clear; empty before they are read.
    const CalibrationValues& cleared_values() const noexcept { return cleared_; }
    /// Empty before they are computed.
    const CalibrationValues& new_values() const noexcept { return new_; }
    /// True if nothing was changed, or the old values are written back.
    bool has_old_values() const noexcept;
    /// In Step::prove only samples taken since the new values are in use.
    const SixFaces& faces() const noexcept { return faces_; }
    const CompassSphere& sphere() const noexcept { return sphere_; }
    /// Of the old values and of the new ones, see SixFaces::fit() and CompassSphere::fit(); std::nullopt before they are
    /// computed.
    std::optional<std::pair<double, double>> residuals() const noexcept { return residuals_; }
    /// True if the faces showed no better error matrix: the old one is kept and residuals are of lengths, see
    /// SixFaces::choose_measure().
    bool keeps_error_matrix() const noexcept { return faces_.measure() == Measure::length; }
    /// How often the device restarted while it was turned, and the sign of the last one.
    unsigned restarts() const noexcept { return restarts_; }
    const Fault& last_restart() const noexcept { return last_restart_; }
    /// The face on which Step::verify measures. It is another face than before if one face alone proves nothing.
    std::optional<Face> face_to_verify() const noexcept {
        return accelerometer_check_ ? std::optional{accelerometer_check_->face()} : std::nullopt;
    }
    /// Whether the device must be turned to that face, see faces_that_prove().
    bool is_further_face() const noexcept { return !verified_faces_.empty(); }
    /// The largest error that Step::verify measured on a face that passed, or the last one it measured, or the residual of
    /// Step::prove: cm/s², or a share of the field.
    std::optional<double> verified() const noexcept;

private:
    void enter(Step step, TimePoint now) noexcept;
    void read_old(TimePoint now);
    void clear(TimePoint now);
    void cleared(TimePoint now);
    void read_cleared(TimePoint now);
    void confirm(TimePoint now);
    void confirmed(TimePoint now);
    void read_values(void (Calibration::*then)(TimePoint), TimePoint now);
    bool is_restarted(TimePoint now);
    void restarted(Fault sign, TimePoint now);
    void add_inertial(const Vector& acceleration, const Vector& rotation, TimePoint now);
    void add_field(const Vector& field, TimePoint now);
    bool is_gone_on(TimePoint now);
    std::optional<std::pair<Vector, Vector>> mean_with(const Vector& acceleration, const Vector& rotation,
                                                       TimePoint now) noexcept;
    void verify(TimePoint now);
    void measured(TimePoint now);
    template <class Found, class Samples>
    void prove(const Samples& samples, TimePoint now);
    void check_parameters(TimePoint now);
    void kept_new_values(TimePoint now);
    void not_verified(TimePoint now);
    std::optional<TimePoint> samples_missing_at() const noexcept;
    void stop_tasks(TimePoint now);
    TimePoint silent_at() const noexcept;
    void end_silent(TimePoint now);
    void fit(TimePoint now);
    void write(TimePoint now);
    void written(TimePoint now);
    void finish_of_another(const Task& part, TimePoint now);
    void restore(End why, TimePoint now);
    void restored(TimePoint now);
    bool order_is_right() const;
    std::optional<CalibrationValues> values_read() const { return calibration_in(*reading_, sensor_); }
    CalibrationValues named(std::span<const float> values) const;
    template <class Samples, class Found>
    void use(const Samples& samples, const Fit<Found>& fit, TimePoint now);
    void make_check(const AccelerometerCalibration& stored);
    void make_check(const CompassCalibration& stored);

    Sensor sensor_;
    DescriptionCache* cache_;
    Step step_ = Step::read;
    DescriptionCache own_cache_;    // used if the caller passes none
    std::unique_ptr<Parameters> reading_;
    std::unique_ptr<ParameterAction> clear_;
    std::unique_ptr<CalibrationWrite> write_;
    std::unique_ptr<CalibrationWrite> restore_;
    CalibrationValues old_, cleared_, new_, other_;
    SixFaces faces_;
    CompassSphere sphere_;
    std::optional<RestartWatch> watch_;    // since the last clear
    bool keeps_new_ = false;
    bool is_proven_ = false;        // its samples fit the fit; its parameters are read once more
    bool was_corrected_ = false;    // the samples needed no correction, once
    bool needs_proof_ = false;      // on all sides
    std::optional<double> proof_;
    unsigned restarts_ = 0;
    unsigned silences_ = 0;    // of those, in a row directly after the clear
    Fault last_restart_;
    std::optional<AccelerometerCheck> accelerometer_check_;
    std::vector<AccelerometerCheck> further_checks_, verified_faces_;    // on other faces than this one
    std::optional<CompassCheck> compass_check_;
    TimePoint step_since_{};
    TimePoint settled_at_{};    // samples count from this time on
    TimePoint last_mean_{};
    Vector acceleration_sum_{}, rotation_sum_{};    // of the samples since then
    unsigned summed_ = 0;
    std::optional<std::pair<double, double>> residuals_;
    std::function<Fault()> refusal_;
    End why_;    // the result when the old values are written back
};

}    // namespace ano::host
