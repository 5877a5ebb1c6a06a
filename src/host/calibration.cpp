#include <ano/typed.hpp>
#include <host/calibration.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <type_traits>
#include <utility>

namespace ano::host {
namespace {

Action clear_of(Sensor sensor) noexcept {
    return sensor == Sensor::accelerometer ? Action::clear_accelerometer_calibration : Action::clear_compass_calibration;
}
Action use_of(Sensor sensor) noexcept {
    return sensor == Sensor::accelerometer ? Action::accelerometer_calibration_sent : Action::store_compass_calibration;
}

/// The name of the first value that differs from the one read from the device; nullptr: all are the same.
const std::string* first_unlike(const CalibrationValues& values, const Parameters& read) {
    for (const auto& [name, value] : values) {
        const ParameterInfo* info = read.find(name).parameter;
        const auto stored = info != nullptr ? read.value(info->id) : std::nullopt;
        if (!stored || !same_bytes(*stored, value, *info)) return &name;
    }
    return nullptr;
}

bool are_same(const CalibrationValues& a, const CalibrationValues& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
        return one.first == other.first && same_bytes(one.second, other.second, Type::f32);
    });
}

// Text for people: "52.7 cm/s²", or "1.5 %".
std::string error_text(double error, Sensor sensor) {
    const auto tenths = std::llround(std::min(error * (sensor == Sensor::accelerometer ? 10 : 1000), 1e6));
    return std::to_string(tenths / 10) + '.' + std::to_string(tenths % 10) + (sensor == Sensor::accelerometer ? " cm/s²" : " %");
}

// Also true for a device that was never calibrated.
bool shows_the_clear(const CalibrationValues& cleared, Sensor sensor) {
    const auto is_zero = [](const auto& one) { return same_bytes(one.second, 0.0, Type::f32); };
    return are_same(cleared, neutral_calibration(sensor)) || std::all_of(cleared.begin(), cleared.end(), is_zero);
}

template <class Found>
Found calibration_of(const CalibrationValues& values) {
    decltype(Found{}.values()) all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<float>(std::get<double>(values[i].second));
    return Found::of(all);
}

double worst_of(const SixFaces& faces, const AccelerometerCalibration& calibration) { return faces.worst(calibration); }
double worst_of(const CompassSphere& sphere, const CompassCalibration& calibration) { return sphere.residual(calibration); }

template <class Found>
using CheckOf = std::conditional_t<std::is_same_v<Found, AccelerometerCalibration>, AccelerometerCheck, CompassCheck>;

// An older device rounds the values that it stores. The rounded values must still be better than the old ones on the same
// samples: as a whole, and where the error is largest. Empty: they are.
template <class Samples, class Found>
Fault why_too_coarse(const Samples& samples, const Fit<Found>& fit, const Found& old, const Found& stored, Sensor sensor) {
    const double after = samples.residual(stored);
    if (!(after <= CheckOf<Found>::limit(fit.after) && after < Samples::max_residual)) return {"too_coarse"};
    if (after >= fit.before) return {"coarse_residual", error_text(after, sensor), error_text(fit.before, sensor)};
    const double most = worst_of(samples, stored), most_before = worst_of(samples, old);
    const bool is_rounded = stored.values() != fit.calibration->values();
    if (!is_rounded || !(most > most_before)) return {};
    return {"coarse_error", error_text(most, sensor), error_text(most_before, sensor)};
}

}    // namespace

std::vector<std::string> calibration_names(Sensor sensor) {
    using Groups = std::vector<std::string_view>;
    const Groups groups = sensor == Sensor::accelerometer ? Groups{"AOFF", "ASEN", "AEM1", "AEM2", "AEM3"}
                                                          : Groups{"MOFF", "MSEN"};
    std::vector<std::string> names;
    for (const std::string_view group : groups)
        for (const char axis : {'X', 'Y', 'Z'}) names.push_back("CAL_" + std::string{group} + '_' + axis);
    return names;
}

CalibrationValues neutral_calibration(Sensor sensor) {
    const auto names = calibration_names(sensor);
    const auto accelerometer = AccelerometerCalibration{}.values();
    const auto compass = CompassCalibration{}.values();
    CalibrationValues values;
    for (std::size_t i = 0; i < names.size(); ++i)
        values.emplace_back(names[i], double{sensor == Sensor::accelerometer ? accelerometer[i] : compass[i]});
    return values;
}

bool may_be_stored_as(const AnyValue& wanted, const AnyValue& has) noexcept {
    if (same_bytes(wanted, has, Type::f32)) return true;
    const auto* const one = std::get_if<double>(&wanted);
    const auto* const other = std::get_if<double>(&has);
    return one != nullptr && other != nullptr && std::abs(*one - *other) <= max_calibration_rounding;
}

CalibrationWrite::CalibrationWrite(Device& device, DescriptionCache* cache, Sensor sensor, CalibrationValues values)
    : Task{device},
      values_{std::move(values)},
      apply_{
          device, cache, values_, {.also_the_same = true, .text = {.beyond_range = true, .rounding = max_calibration_rounding}}},
      use_{device, use_of(sensor)},
      again_{device, cache} {}

void CalibrationWrite::start(TimePoint now) {
    apply_.on_end([this](TimePoint then) { applied(then); });
    use_.on_end([this](TimePoint then) { on_use_ended(then); });
    again_.on_end([this](TimePoint then) { read_back(then); });
    apply_.mean(identity());
    use_.mean(identity());
    apply_.start(now);
}

void CalibrationWrite::applied(TimePoint now) {
    if (apply_.end()->ending != Ending::done) return finish_as(apply_, now);
    for (std::size_t i = 0; i < values_.size(); ++i) {
        const ParameterApply::Row& row = apply_.rows()[i];
        if (row.state != ParameterApply::State::written) return finish({Ending::refused, row.fault, {}}, now);
        if (row.stored) values_[i].second = *row.stored;
    }
    use_.start(now);
}

void CalibrationWrite::on_use_ended(TimePoint now) {
    if (use_.end()->ending != Ending::done) return finish_as(use_, now);
    std::vector<std::string> names;
    for (const auto& [name, value] : values_) names.push_back(name);
    again_.read_named(std::move(names), now);
}

void CalibrationWrite::read_back(TimePoint now) {
    if (again_.end()->ending != Ending::done) return finish_as(again_, now);
    if (finds_another()) return finish_another({}, now);
    if (const std::string* name = first_unlike(values_, again_))
        return finish({Ending::refused, {"does_not_keep", hex_of(device().address()), *name}, {}}, now);
    finish({}, now);
}

void CalibrationWrite::cancel(TimePoint now) {
    apply_.on_end({});
    use_.on_end({});
    again_.on_end({});
    apply_.cancel(now);
    use_.cancel(now);
    again_.cancel(now);
    finish({Ending::cancelled, {"some_written"}, {}}, now);
}

Calibration::Calibration(Device& device, Sensor sensor, DescriptionCache* cache)
    : Task{device}, sensor_{sensor}, cache_{cache != nullptr ? cache : &own_cache_} {}

void Calibration::enter(Step step, TimePoint now) noexcept {
    step_ = step;
    step_since_ = now;
}

void Calibration::read_values(void (Calibration::*then)(TimePoint), TimePoint now) {
    reading_ = std::make_unique<Parameters>(device(), cache_);
    reading_->on_end([this, then](TimePoint at) { (this->*then)(at); });
    std::vector<std::string> names = calibration_names(sensor_);
    if (step_ == Step::read) std::ranges::copy(calibration_names(other_than(sensor_)), std::back_inserter(names));
    reading_->read_named(std::move(names), now);
}

void Calibration::start(TimePoint now) {
    enter(Step::read, now);
    read_values(&Calibration::read_old, now);
}

void Calibration::read_old(TimePoint now) {
    if (end()) return;
    if (reading_->end()->ending != Ending::done) return finish_as(*reading_, now);
    if (!order_is_right()) return finish({Ending::unsupported, {"calibration_unsupported", hex_of(device().address())}, {}}, now);
    renew_identity();
    old_ = *values_read();
    other_ = calibration_in(*reading_, other_than(sensor_)).value_or(CalibrationValues{});
    enter(Step::keep, now);
}

std::optional<CalibrationValues> calibration_in(const Parameters& parameters, Sensor sensor) {
    CalibrationValues values;
    for (const std::string& name : calibration_names(sensor)) {
        const ParameterInfo* info = parameters.find(name).parameter;
        auto value = info != nullptr ? parameters.value(info->id) : std::nullopt;
        if (!value) return std::nullopt;
        values.emplace_back(name, *std::move(value));
    }
    return values;
}

// Whether the parameters have consecutive ids, and each is an f32 or, on an older device, an i32 with a known scale.
bool Calibration::order_is_right() const {
    std::optional<std::size_t> next;
    for (const std::string& name : calibration_names(sensor_)) {
        const ParameterInfo* info = reading_->find(name).parameter;
        if (info == nullptr || !(info->type == Type::f32 || info->is_scaled()) || (next && info->id != *next)) return false;
        next = info->id + std::size_t{1};
    }
    return true;
}

void Calibration::set_old_values(CalibrationValues values) {
    if (step_ != Step::keep || end() || values.size() != old_.size()) return;
    for (auto& [name, value] : values)
        if (const ParameterInfo* info = reading_->find(name).parameter) value = nearest_value(value, *info);
    old_ = std::move(values);
}

void Calibration::kept(TimePoint now) {
    if (end()) return;
    if (step_ == Step::keep) clear(now);
    else if (step_ == Step::keep_new) write(now);
}

void Calibration::not_kept(const std::string& why, TimePoint now) {
    if (step_ == Step::keep_new && !end()) restore({Ending::failed, {"new_values_not_saved", why}, {}}, now);
}

void Calibration::clear(TimePoint now) {
    enter(Step::clear, now);
    clear_ = std::make_unique<ParameterAction>(device(), clear_of(sensor_));
    clear_->mean(identity());
    clear_->compare_info();
    clear_->on_end([this](TimePoint then) { cleared(then); });
    clear_->start(now);
}

// Some devices show in their parameters that they are cleared: the values are read, to be compared later.
void Calibration::cleared(TimePoint now) {
    if (end() || step_ != Step::clear) return;
    if (clear_->is_of_another()) return finish_of_another(*clear_, now);
    if (clear_->end()->ending != Ending::done) return restore(*clear_->end(), now);
    settled_at_ = now + most_late;
    watch_.emplace(device(), now);    // from now on, since it may restart at once
    read_values(&Calibration::read_cleared, now);
}

void Calibration::read_cleared(TimePoint now) {
    if (end() || step_ != Step::clear) return;
    if (reading_->end()->ending == Ending::timeout && now < silent_at()) return;    // read again when a frame of it is received
    if (reading_->end()->ending != Ending::done) return restore(*reading_->end(), now);
    if (is_restarted(now)) return;
    const auto values = values_read();
    if (!values) return restore({Ending::incomplete, {"cleared_unknown"}, {}}, now);
    cleared_ = *values;
    faces_ = {};
    sphere_ = {};
    enter(Step::turn, now);
}

bool Calibration::is_restarted(TimePoint now) {
    const Fault sign = watch_ ? watch_->sign(device()) : Fault{};
    if (!sign.empty()) restarted(sign, now);
    return !sign.empty();
}

void Calibration::restarted(Fault sign, TimePoint now) {
    last_restart_ = std::move(sign);
    const std::string silence = watch_ ? watch_->silence_at_begin() : std::string{};
    silences_ = silence.empty() ? 0 : silences_ + 1;
    watch_.reset();
    if (step_ == Step::clear || step_ == Step::confirm) {
        reading_->on_end({});
        reading_->cancel(now);
    }
    ++restarts_;
    if (silences_ == max_silences)
        return restore({Ending::failed, {"silent_after_clear", hex_of(device().address()), silence, silences_}, {}}, now);
    if (restarts_ <= max_restarts) return clear(now);
    restore({Ending::failed, {"restarts_often", hex_of(device().address()), restarts_, last_restart_}, {}}, now);
}

void Calibration::receive(FrameView frame, TimePoint now) {
    const bool is_cleared = step_ == Step::clear && watch_;
    const bool is_corrected = step_ == Step::verify || step_ == Step::prove;
    const bool measures = is_cleared || step_ == Step::turn || step_ == Step::confirm || is_corrected;
    if (!measures || end() || !may_be_of(frame.source(), device().address())) return;
    if (!is_corrected && is_restarted(now)) return;
    if (is_cleared && reading_->end()) read_values(&Calibration::read_cleared, now);
    if (sensor_ == Sensor::accelerometer) {
        if (const auto m = as<"inertial">(frame))
            add_inertial({double(m->get<"acc_x">()), double(m->get<"acc_y">()), double(m->get<"acc_z">())},
                         {m->get<"gyr_x">(), m->get<"gyr_y">(), m->get<"gyr_z">()}, now);
        return;
    }
    const auto add = [&](const auto& m) {
        if (m)
            add_field(
                {double(m->template get<"mag_x">()), double(m->template get<"mag_y">()), double(m->template get<"mag_z">())},
                now);
    };
    add(as<"compass">(frame));
    add(as<"compass", "field">(frame));
}

void Calibration::add_inertial(const Vector& acceleration, const Vector& rotation, TimePoint now) {
    if (is_gone_on(now)) return;
    const auto sample = mean_with(acceleration, rotation, now);
    if (!sample) return;
    if (step_ == Step::verify) {
        accelerometer_check_->add(sample->first, sample->second);
        return verify(now);
    }
    faces_.add(sample->first, sample->second);
    if (faces_.is_complete()) measured(now);
}

std::optional<std::pair<Vector, Vector>> Calibration::mean_with(const Vector& acceleration, const Vector& rotation,
                                                                TimePoint now) noexcept {
    ++summed_;
    for (std::size_t i = 0; i < 3; ++i) {
        acceleration_sum_[i] += acceleration[i];
        rotation_sum_[i] += rotation[i];
    }
    if (now - last_mean_ < spacing) return std::nullopt;
    last_mean_ = now;
    std::pair mean{std::exchange(acceleration_sum_, {}), std::exchange(rotation_sum_, {})};
    for (Vector* sum : {&mean.first, &mean.second})
        for (double& axis : *sum) axis /= summed_;
    summed_ = 0;
    return mean;
}

void Calibration::add_field(const Vector& field, TimePoint now) {
    if (is_gone_on(now)) return;
    if (step_ == Step::verify) {
        compass_check_->add(field);
        return verify(now);
    }
    sphere_.add(field);
    if (sphere_.is_complete()) measured(now);
}

void Calibration::measured(TimePoint now) {
    if (step_ != Step::prove) return confirm(now);
    if (sensor_ == Sensor::accelerometer) prove<AccelerometerCalibration>(faces_, now);
    else prove<CompassCalibration>(sphere_, now);
}

// Whether a sample can't be used: it may be from before a clear or a store, it follows a gap, or enough were collected.
bool Calibration::is_gone_on(TimePoint now) {
    if (step_ == Step::verify || step_ == Step::prove) return is_proven_ || now < settled_at_;
    watch_->sampled(now);
    return is_restarted(now) || step_ != Step::turn || now < settled_at_;
}

void Calibration::confirm(TimePoint now) {
    enter(Step::confirm, now);
    read_values(&Calibration::confirmed, now);
}

void Calibration::confirmed(TimePoint now) {
    if (end() || step_ != Step::confirm) return;
    if (reading_->end()->ending != Ending::done) return restore(*reading_->end(), now);
    if (is_restarted(now)) return;
    const auto values = values_read();
    if (!values || !are_same(*values, cleared_)) return restarted({"not_as_cleared"}, now);
    fit(now);
}

TimePoint Calibration::silent_at() const noexcept {
    const Duration least = step_ == Step::restore ? time_to_answer : silent_after;
    return std::max(device().heard_at().value_or(step_since_) + silent_after, step_since_ + least);
}

// std::nullopt: in this step the device need not send samples.
std::optional<TimePoint> Calibration::samples_missing_at() const noexcept {
    if (step_ != Step::turn) return std::nullopt;
    return std::max(watch_->sampled_at(), step_since_) + silent_after;
}

std::optional<TimePoint> Calibration::due() const noexcept {
    if (end() || step_ == Step::read || step_ == Step::keep) return std::nullopt;
    TimePoint first = silent_at();
    if (step_ == Step::turn) first = std::min({first, step_since_ + time_to_turn, *samples_missing_at()});
    if (step_ == Step::verify) first = std::min(first, step_since_ + time_to_verify);
    if (step_ == Step::prove) first = std::min(first, step_since_ + time_to_turn);
    return first;
}

void Calibration::look(TimePoint now) {
    if (const auto at = due(); !at || now < *at) return;
    if (now >= silent_at()) return end_silent(now);
    if (step_ == Step::verify) return not_verified(now);
    if (now >= step_since_ + time_to_turn) return restore({Ending::timeout, {"not_turned"}, {}}, now);
    const char* what = sensor_ == Sensor::accelerometer ? "inertial (0x01)" : "compass (0x02)";
    restore({Ending::failed, {"no_samples", hex_of(device().address()), what}, {}}, now);
}

// A device that is off can't receive the old values either.
void Calibration::end_silent(TimePoint now) {
    if (step_ != Step::restore) why_ = {Ending::timeout, {"stopped_sending", hex_of(device().address()), "4.5"}, {}};
    stop_tasks(now);
    if (restore_) {
        restore_->mean(identity());
        restore_->on_end({});
        restore_->cancel(now);
    }
    why_.fault.add({"old_values_not_restored"});
    finish(why_, now);
}

Progress Calibration::progress() const noexcept {
    if (sensor_ == Sensor::accelerometer) return {faces_.faces_done(), 6};
    return {sphere_.map().count(), CompassSphere::cells};
}

void Calibration::fit(TimePoint now) {
    if (sensor_ == Sensor::accelerometer) {
        const auto old = calibration_of<AccelerometerCalibration>(old_);
        faces_.measure_by(faces_.choose_measure(old));
        return use(faces_, faces_.fit(old), now);
    }
    use(sphere_, sphere_.fit(calibration_of<CompassCalibration>(old_)), now);
}

template <class Samples, class Found>
void Calibration::use(const Samples& samples, const Fit<Found>& fit, TimePoint now) {
    const double limit = CheckOf<Found>::limit(fit.after);
    const bool is_corrected = fit.calibration && samples.residual(Found{}) <= limit && fit.before > limit;
    if (is_corrected && !std::exchange(was_corrected_, true)) return restarted({"already_corrected"}, now);
    needs_proof_ = is_corrected || !shows_the_clear(cleared_, sensor_);
    residuals_ = std::pair{fit.before, fit.after};
    if (!fit.calibration) return restore({Ending::failed, {"rejected", fit.wrong}, {}}, now);
    if (is_corrected && !shows_the_clear(cleared_, sensor_))
        return restore({Ending::failed, {"ignores_clear", hex_of(device().address())}, {}}, now);
    new_ = named(fit.calibration->values());
    const auto stored = calibration_of<Found>(new_);
    residuals_->second = samples.residual(stored);
    if (const Fault why = why_too_coarse(samples, fit, calibration_of<Found>(old_), stored, sensor_); !why.empty())
        return restore({Ending::failed, {"rejected", why}, {}}, now);
    make_check(stored);
    if (keeps_new_) return enter(Step::keep_new, now);
    write(now);
}

void Calibration::write(TimePoint now) {
    if (const Fault why = refusal_ ? refusal_() : Fault{}; !why.empty())
        return restore({Ending::refused, {"new_values_not_written", why}, {}}, now);
    enter(Step::write, now);
    write_ = std::make_unique<CalibrationWrite>(device(), cache_, sensor_, new_);
    write_->mean(identity());
    write_->on_end([this](TimePoint then) { written(then); });
    write_->start(now);
}

// The check starts on the face that was completed last.
void Calibration::make_check(const AccelerometerCalibration& stored) {
    further_checks_.clear();
    const auto old = calibration_of<AccelerometerCalibration>(old_);
    for (const Face face : faces_that_prove(stored, old, faces_, faces_.face().value_or(Face::z_plus)))
        further_checks_.emplace_back(face, error_on(face, stored.corrected(faces_.mean(face)), faces_.measure()),
                                     faces_.measure());
    accelerometer_check_ = further_checks_.front();
    further_checks_.erase(further_checks_.begin());
    if (needs_proof_) further_checks_.clear();    // all faces follow
}

void Calibration::make_check(const CompassCalibration& stored) {
    compass_check_.emplace(sphere_.strength(stored), residuals_->second);
}

CalibrationValues Calibration::named(std::span<const float> values) const {
    CalibrationValues all;
    for (std::size_t i = 0; i < values.size(); ++i)
        all.emplace_back(old_[i].first, nearest_value(double{values[i]}, *reading_->find(old_[i].first).parameter));
    return all;
}

void Calibration::written(TimePoint now) {
    if (end() || step_ != Step::write) return;
    if (write_->is_of_another()) return finish_of_another(*write_, now);
    if (write_->end()->ending != Ending::done) return restore(*write_->end(), now);
    new_ = write_->values();
    is_proven_ = false;
    settled_at_ = now + most_late;
    enter(Step::verify, now);
}

std::optional<double> Calibration::verified() const noexcept {
    if (proof_) return proof_;
    if (!accelerometer_check_) return compass_check_ ? compass_check_->error() : std::nullopt;
    auto worst = accelerometer_check_->error();
    for (const AccelerometerCheck& check : verified_faces_) worst = std::max(worst, check.error());
    return worst;
}

void Calibration::verify(TimePoint now) {
    if (!(accelerometer_check_ ? accelerometer_check_->is_passed() : compass_check_->is_passed())) return;
    if (further_checks_.empty()) {
        if (!needs_proof_) return check_parameters(now);
        const Measure measure = faces_.measure();
        faces_ = {};
        faces_.measure_by(measure);
        sphere_ = {};
        return enter(Step::prove, now);
    }
    verified_faces_.push_back(*accelerometer_check_);
    accelerometer_check_ = further_checks_.front();
    further_checks_.erase(further_checks_.begin());
    enter(Step::verify, now);
}

template <class Found, class Samples>
void Calibration::prove(const Samples& samples, TimePoint now) {
    const double with_new = samples.residual(Found{}), best = samples.fit(Found{}).after;
    const double with_old = samples.residual(calibration_of<Found>(old_), calibration_of<Found>(new_));
    proof_ = with_new;
    using Check = CheckOf<Found>;
    const bool is_best = best < Samples::max_residual && with_new <= Check::times_promised * best + Check::margin;
    if (is_best && !(with_new > with_old + Check::margin)) return check_parameters(now);
    const std::string error = error_text(with_new, sensor_);
    restore({Ending::failed,
             is_best ? Fault{"not_verified_worse", error, error_text(with_old, sensor_)}
                     : Fault{"not_verified_raw", error, error_text(best, sensor_)},
             {}},
            now);
}

void Calibration::check_parameters(TimePoint now) {
    is_proven_ = true;
    read_values(&Calibration::kept_new_values, now);
}

// If the device restarts before it has stored the new values, it uses its old ones again, and the face on which it was measured
// may not show this.
void Calibration::kept_new_values(TimePoint now) {
    if (end() || !is_proven_ || step_ == Step::restore) return;
    if (reading_->end()->ending != Ending::done) return restore(*reading_->end(), now);
    if (!finds_another() && first_unlike(new_, *reading_) == nullptr) return finish({}, now);
    restore({Ending::failed, {"new_values_lost", hex_of(device().address())}, {}}, now);
}

void Calibration::not_verified(TimePoint now) {
    const bool faces = accelerometer_check_.has_value();
    const std::string_view face = faces ? name_of(accelerometer_check_->face()) : std::string_view{};
    const auto error = faces ? accelerometer_check_->error() : compass_check_->error();
    if (!error)
        return restore({Ending::failed, faces ? Fault{"not_verified_moving", face} : Fault{"not_verified_still"}, {}}, now);
    const std::string promised = error_text(faces ? accelerometer_check_->promised() : compass_check_->promised(), sensor_);
    const std::string is = error_text(*error, sensor_);
    restore({Ending::failed, faces ? Fault{"not_verified_on", is, face, promised} : Fault{"not_verified", is, promised}, {}},
            now);
}

// The old values belong to the previous device.
void Calibration::finish_of_another(const Task& part, TimePoint now) {
    be_of_another();
    finish({Ending::failed, Fault{part.end()->fault}.add({"old_values_not_to_that"}), {}}, now);
}

void Calibration::restore(End why, TimePoint now) {
    why_ = std::move(why);
    enter(Step::restore, now);
    restore_ = std::make_unique<CalibrationWrite>(device(), cache_, sensor_, old_);
    restore_->on_end([this](TimePoint then) { restored(then); });
    restore_->start(now);
}

void Calibration::restored(TimePoint now) {
    const bool back = restore_->end()->ending == Ending::done;
    why_.fault.add(back ? Fault{"old_values_restored"} : Fault{"old_values_not_restored_why", restore_->end()->fault});
    finish(why_, now);
}

bool Calibration::has_old_values() const noexcept {
    return restore_ ? restore_->end() && restore_->end()->ending == Ending::done : !clear_;
}

void Calibration::stop_tasks(TimePoint now) {
    const auto stop = [&](Task* task) {
        if (task == nullptr) return;
        task->on_end({});
        task->cancel(now);
    };
    stop(reading_.get());
    stop(clear_.get());
    stop(write_.get());
}

void Calibration::cancel(TimePoint now) {
    if (end() || step_ == Step::restore) return;
    stop_tasks(now);
    if (step_ == Step::read || step_ == Step::keep) return finish({Ending::cancelled, {"nothing_changed"}, {}}, now);
    restore({Ending::cancelled, {"cancelled"}, {}}, now);
}

}    // namespace ano::host
