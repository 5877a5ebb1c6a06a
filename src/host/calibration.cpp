#include <ano/typed.hpp>
#include <host/calibration.hpp>

#include <algorithm>
#include <array>

namespace ano::host {
namespace {

Action clear_of(Sensor sensor) noexcept {
    return sensor == Sensor::accelerometer ? Action::clear_accelerometer_calibration : Action::clear_compass_calibration;
}
Action use_of(Sensor sensor) noexcept {
    return sensor == Sensor::accelerometer ? Action::accelerometer_calibration_sent : Action::store_compass_calibration;
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

CalibrationWrite::CalibrationWrite(Device& device, DescriptionCache* cache, Sensor sensor, CalibrationValues values)
    : Task{device},
      values_{std::move(values)},
      apply_{device, cache, values_, {.also_the_same = true}},
      use_{device, use_of(sensor)},
      again_{device, cache} {}

void CalibrationWrite::start(TimePoint now) {
    apply_.on_end([this](TimePoint then) { applied(then); });
    use_.on_end([this](TimePoint then) { told(then); });
    again_.on_end([this](TimePoint then) { read_back(then); });
    apply_.start(now);
}

void CalibrationWrite::applied(TimePoint now) {
    if (apply_.end()->ending != Ending::done) return finish_as(apply_, now);
    for (const auto& row : apply_.rows())
        if (row.state != ParameterApply::State::written) return finish({Ending::refused, row.what, {}}, now);
    use_.start(now);
}

void CalibrationWrite::told(TimePoint now) {
    if (use_.end()->ending != Ending::done) return finish_as(use_, now);
    std::vector<std::string> names;
    for (const auto& [name, value] : values_) names.push_back(name);
    again_.read_named(std::move(names), now);
}

void CalibrationWrite::read_back(TimePoint now) {
    if (again_.end()->ending != Ending::done) return finish_as(again_, now);
    for (const auto& [name, value] : values_) {
        const ParameterInfo* info = again_.find(name).parameter;
        const auto stored = info != nullptr ? again_.value(info->id) : std::nullopt;
        if (!stored || !same_bytes(*stored, value, Type::f32))
            return finish({Ending::refused, hex_of(device().address()) + " does not keep " + name, {}}, now);
    }
    finish({}, now);
}

void CalibrationWrite::cancel(TimePoint now) {
    apply_.on_end({});
    use_.on_end({});
    again_.on_end({});
    apply_.cancel(now);
    use_.cancel(now);
    again_.cancel(now);
    finish({Ending::cancelled, "cancelled, some values may be written", {}}, now);
}

Calibration::Calibration(Device& device, Sensor sensor, DescriptionCache* cache)
    : Task{device}, sensor_{sensor}, cache_{cache}, parameters_{device, cache}, clear_{device, clear_of(sensor)} {}

void Calibration::start(TimePoint now) {
    parameters_.on_end([this](TimePoint then) { read_old(then); });
    clear_.on_end([this](TimePoint then) { cleared(then); });
    parameters_.read_named(calibration_names(sensor_), now);
}

void Calibration::read_old(TimePoint now) {
    if (end()) return;
    if (parameters_.end()->ending != Ending::done) return finish_as(parameters_, now);
    if (!order_is_right())
        return finish(
            {Ending::unsupported, hex_of(device().address()) + " has not the parameters of this calibration in their order", {}},
            now);
    for (const std::string& name : calibration_names(sensor_))
        old_.emplace_back(name, *parameters_.value(parameters_.find(name).parameter->id));
    step_ = Step::keep;
}

// Whether the parameters have consecutive ids and each is an f32.
bool Calibration::order_is_right() const {
    std::optional<std::size_t> next;
    for (const std::string& name : calibration_names(sensor_)) {
        const ParameterInfo* info = parameters_.find(name).parameter;
        if (info == nullptr || info->type != Type::f32 || (next && info->id != *next)) return false;
        next = info->id + std::size_t{1};
    }
    return true;
}

void Calibration::set_old_values(CalibrationValues values) {
    if (step_ == Step::keep && !end() && values.size() == old_.size()) old_ = std::move(values);
}

void Calibration::kept(TimePoint now) {
    if (step_ != Step::keep || end()) return;
    step_ = Step::clear;
    clear_.start(now);
}

void Calibration::cleared(TimePoint now) {
    if (end() || step_ != Step::clear) return;
    if (clear_.end()->ending != Ending::done) return restore(*clear_.end(), now);
    step_ = Step::turn;
    turn_until_ = now + time_to_turn;
}

void Calibration::hear(FrameView frame, TimePoint now) {
    if (step_ != Step::turn || end() || !may_be_of(frame.source(), device().address())) return;
    if (sensor_ == Sensor::accelerometer) {
        const auto m = as<"inertial">(frame);
        if (!m) return;
        faces_.take({double(m->get<"acc_x">()), double(m->get<"acc_y">()), double(m->get<"acc_z">())},
                    {m->get<"gyr_x">(), m->get<"gyr_y">(), m->get<"gyr_z">()});
        if (faces_.is_complete()) turned(now);
        return;
    }
    const auto take = [&](const auto& m) {
        if (m)
            sphere_.take(
                {double(m->template get<"mag_x">()), double(m->template get<"mag_y">()), double(m->template get<"mag_z">())});
    };
    take(as<"compass">(frame));
    take(as<"compass", "field">(frame));
    if (sphere_.is_complete()) turned(now);
}

void Calibration::look(TimePoint now) {
    if (const auto until = due(); until && now >= *until && !end())
        restore({Ending::timeout, "it was not turned to all sides within 10 minutes", {}}, now);
}

Progress Calibration::progress() const noexcept {
    if (sensor_ == Sensor::accelerometer) return {faces_.faces_done(), 6};
    return {sphere_.map().count(), CompassSphere::cells};
}

template <std::size_t N>
std::array<float, N> Calibration::old() const {
    std::array<float, N> values{};
    for (std::size_t i = 0; i < N; ++i) values[i] = static_cast<float>(std::get<double>(old_[i].second));
    return values;
}

void Calibration::turned(TimePoint now) {
    if (sensor_ == Sensor::accelerometer) return use(faces_.fit(AccelerometerCalibration::of(old<15>())), now);
    use(sphere_.fit(CompassCalibration::of(old<6>())), now);
}

template <class Found>
void Calibration::use(const Fit<Found>& fit, TimePoint now) {
    residuals_ = std::pair{fit.before, fit.after};
    if (!fit.calibration) return restore({Ending::failed, "rejected: " + fit.wrong, {}}, now);
    if (const std::string why = refusal_ ? refusal_() : ""; !why.empty())
        return restore({Ending::refused, "the new values were not written: " + why, {}}, now);
    step_ = Step::write;
    const auto values = fit.calibration->values();
    new_ = named(values);
    write_ = std::make_unique<CalibrationWrite>(device(), cache_, sensor_, new_);
    write_->on_end([this](TimePoint then) { written(then); });
    write_->start(now);
}

CalibrationValues Calibration::named(std::span<const float> values) const {
    CalibrationValues all;
    for (std::size_t i = 0; i < values.size(); ++i) all.emplace_back(old_[i].first, double{values[i]});
    return all;
}

void Calibration::written(TimePoint now) {
    if (end() || step_ != Step::write) return;
    if (write_->end()->ending != Ending::done) return restore(*write_->end(), now);
    finish({}, now);
}

void Calibration::restore(End why, TimePoint now) {
    why_ = std::move(why);
    step_ = Step::restore;
    restore_ = std::make_unique<CalibrationWrite>(device(), cache_, sensor_, old_);
    restore_->on_end([this](TimePoint then) { restored(then); });
    restore_->start(now);
}

void Calibration::restored(TimePoint now) {
    const bool back = restore_->end()->ending == Ending::done;
    why_.what += back ? "; the old values are back" : "; the old values could not be written back: " + restore_->end()->what;
    finish(why_, now);
}

bool Calibration::has_old_values() const noexcept {
    if (restore_) return restore_->end() && restore_->end()->ending == Ending::done;
    return !write_ && !clear_.end() && step_ != Step::clear;
}

void Calibration::cancel(TimePoint now) {
    if (end() || step_ == Step::restore) return;
    const Step was = step_;
    parameters_.on_end({});
    parameters_.cancel(now);
    clear_.on_end({});
    clear_.cancel(now);
    if (write_) {
        write_->on_end({});
        write_->cancel(now);
    }
    if (was == Step::read || was == Step::keep) return finish({Ending::cancelled, "cancelled, nothing was changed", {}}, now);
    restore({Ending::cancelled, "cancelled", {}}, now);
}

}    // namespace ano::host
