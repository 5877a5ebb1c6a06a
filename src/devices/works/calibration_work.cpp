#include <ano/hex.hpp>
#include <ano_json/compact_json.hpp>
#include <devices/device_json.hpp>
#include <devices/unit_note.hpp>
#include <devices/works/calibration_work.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::TimePoint;
using ano::host::Calibration;
using ano::host::CalibrationValues;
using ano::host::Sensor;
using ano::host::Task;

double hundredths(double value) { return std::round(value * 100) / 100; }

std::string_view name_of(Sensor sensor) { return sensor == Sensor::accelerometer ? "accelerometer" : "compass"; }

Json values_json(const CalibrationValues& values) {
    Json json = Json::object();
    for (const auto& [name, value] : values) json[name] = value_json(value, ano::Type::f32);
    return json;
}

// {"face": "+x", "still": 1.0, "faces": {"+x": 0.5, …}, "done": ["-z"]}
Json faces_json(const ano::host::SixFaces& faces) {
    Json json{{"face", nullptr}, {"still", 0}, {"faces", Json::object()}, {"done", Json::array()}};
    if (const auto face = faces.face()) json["face"] = ano::host::name_of(*face);
    if (const auto unrest = faces.unrest()) json["still"] = hundredths(1 / std::max(1.0, *unrest));
    for (std::size_t i = 0; i < ano::host::face_names.size(); ++i) {
        const auto face = static_cast<ano::host::Face>(i);
        const double share = double(faces.samples(face)) / double{ano::host::SixFaces::enough};
        json["faces"][std::string{ano::host::name_of(face)}] = hundredths(std::min(1.0, share));
        if (faces.is_enough(face)) json["done"].push_back(ano::host::name_of(face));
    }
    return json;
}

// {"bands": 6, "sectors": 12, "coverage": [0, 1, …], "filled": 0.6}
Json sphere_json(const ano::host::CompassSphere& sphere) {
    using Sphere = ano::host::CompassSphere;
    Json cells = Json::array();
    for (std::size_t i = 0; i < Sphere::cells; ++i) cells.push_back(sphere.map().test(i) ? 1 : 0);
    return {{"bands", Sphere::bands},
            {"sectors", Sphere::sectors},
            {"coverage", std::move(cells)},
            {"filled", hundredths(sphere.coverage())},
            {"samples", sphere.samples()}};
}

// As on the wire, so that a NaN is restored exactly: {"CAL_AOFF_X": "0000c07f", …}
Json bytes_json(const CalibrationValues& values) {
    Json json = Json::object();
    for (const auto& [name, value] : values) {
        std::vector<std::uint8_t> bytes;
        (void)ano::host::append(bytes, value, ano::Type::f32);
        json[name] = ano::hex(bytes);
    }
    return json;
}

std::optional<ano::host::AnyValue> value_of_hex(const Json& json) {
    const auto bytes = json.is_string() ? ano::from_hex(json.get_ref<const std::string&>()) : std::nullopt;
    return bytes && bytes->size() == sizeof(float) ? ano::host::value_of(*bytes, ano::Type::f32) : std::nullopt;
}

// Parses the form of value_json().
std::optional<ano::host::AnyValue> parse_value(const Json& json) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (json == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (json == "inf") return infinity;
    if (json == "-inf") return -infinity;
    if (!json.is_number() || std::abs(json.get<double>()) > std::numeric_limits<float>::max()) return std::nullopt;
    return double{json.get<float>()};
}

// The values in a note; std::nullopt: it is damaged. Notes of older versions have no "bytes".
std::optional<CalibrationValues> values_in_note(const std::string& text, Sensor sensor) {
    const Json note = note_json(text);
    const bool has_bytes = note.is_object() && note.contains("bytes");
    const Json kept = note.is_object() ? note.value(has_bytes ? "bytes" : "parameters", Json{}) : Json{};
    if (!kept.is_object()) return std::nullopt;
    CalibrationValues values;
    for (const std::string& name : ano::host::calibration_names(sensor)) {
        const Json one = kept.value(name, Json{});
        auto value = has_bytes ? value_of_hex(one) : parse_value(one);
        if (!value) return std::nullopt;
        values.emplace_back(name, *std::move(value));
    }
    return values;
}

// Other values in a note, under this key; std::nullopt: it has none.
std::optional<CalibrationValues> further_values(const Json& note, const char* key, Sensor sensor) {
    const Json kept = note.is_object() ? note.value(key, Json{}) : Json{};
    CalibrationValues values;
    for (const std::string& name : ano::host::calibration_names(sensor)) {
        auto value = value_of_hex(kept.is_object() ? kept.value(name, Json{}) : Json{});
        if (!value) return std::nullopt;
        values.emplace_back(name, *std::move(value));
    }
    return values;
}

bool are_same(const CalibrationValues& a, const CalibrationValues& b) {
    return std::ranges::equal(
        a, b, [](const auto& one, const auto& other) { return ano::host::same_bytes(one.second, other.second, ano::Type::f32); });
}

// The unit of a note, by the values of the device.
enum class Unit : std::uint8_t {
    other,    // of another one of its type, or the unit was calibrated otherwise meanwhile
    alike,    // it may be the same, or one that was never calibrated
    same,
};

// Whether a value distinguishes a unit from others of its type: a unit that was never calibrated, or is cleared, has the neutral
// one.
bool is_distinct_from(const ano::host::AnyValue& value, const ano::host::AnyValue& neutral) {
    const auto* number = std::get_if<double>(&value);
    return number != nullptr && std::isfinite(*number) && *number != 0 && !ano::host::same_bytes(value, neutral, ano::Type::f32);
}

// The sets of values that a calibration may have left in a device: the old ones, those after the clear, and the new ones. A
// calibration that ended directly after the clear stored no cleared values: it left neutral ones.
std::vector<CalibrationValues> left_by_calibration(const std::string& text, Sensor sensor) {
    const Json note = note_json(text);
    std::vector<CalibrationValues> left{further_values(note, "cleared", sensor).value_or(ano::host::neutral_calibration(sensor))};
    if (auto old = values_in_note(text, sensor)) left.push_back(*std::move(old));
    if (auto found = further_values(note, "new", sensor)) left.push_back(*std::move(found));
    return left;
}

// The device is the one of the note if each value is one that the calibration left, those of the other sensor are unchanged, and
// one of them distinguishes it from others of its type: units have no serial number.
Unit unit_of_note(const CalibrationValues& has, const CalibrationValues& has_of_other, const std::string& text, Sensor sensor) {
    const Sensor other = ano::host::other_than(sensor);
    const auto other_values = further_values(note_json(text), "other", other);
    if (other_values && !are_same(*other_values, has_of_other)) return Unit::other;
    const std::vector<CalibrationValues> left = left_by_calibration(text, sensor);
    const CalibrationValues neutral = ano::host::neutral_calibration(sensor),
                            neutral_other = ano::host::neutral_calibration(other);
    bool is_distinct = false;
    for (std::size_t i = 0; i < has.size(); ++i) {
        const auto& value = has[i].second;
        const auto is_it = [&](const auto& one) { return ano::host::may_be_stored_as(one[i].second, value); };
        if (std::none_of(left.begin(), left.end(), is_it)) return Unit::other;
        is_distinct = is_distinct || (!is_it(left[0]) && is_distinct_from(value, neutral[i].second));
    }
    for (std::size_t i = 0; other_values && i < other_values->size(); ++i)
        is_distinct = is_distinct || is_distinct_from((*other_values)[i].second, neutral_other[i].second);
    return is_distinct ? Unit::same : Unit::alike;
}

// How the user can write the values of a note back, as a clause.
std::string by_hand(const WorkPlace& place, const std::string& name) {
    return "anoctl param import " + place.net.kept_path(name) + ", then anoctl param save";
}

constexpr ano::FaultId<> not_distinguishable{"not_distinguishable"};

// The note is the only copy of its values, so they are logged.
ano::Fault drop_note(const WorkPlace& place, const std::string& name, Unit unit) {
    const std::string text = *place.journal.find(name);
    const bool is_alike = unit == Unit::alike;
    place.journal.drop(name,
                       is_alike ? "removed: it may be of another unit" : "removed: the device has other calibration values");
    const std::string values = describe_note(name, text) + ", " + ano::compact_json(note_json(text).value("parameters", Json{}));
    if (is_alike) return {"saved_for_another", ano::Fault{not_distinguishable}, values};
    return {"saved_values_differ", values};
}

// The name of the stored values of exactly this device; empty: there are none.
std::string kept_note(const WorkPlace& place, Sensor sensor) {
    return find_note(place, [sensor](std::string_view name) { return sensor_of_note(name) == sensor; });
}

class WriteBack final : public TaskWork {
public:
    WriteBack(const WorkPlace& place, std::string name) : TaskWork{place}, name_{std::move(name)} {}
    void start(TimePoint now) override {
        const auto sensor = sensor_of_note(name_);
        if (!sensor) return finish(work_fault({"not_a_calibration", name_}));
        auto task = std::make_unique<ano::host::Parameters>(place().device, &place().cache);
        std::vector<std::string> names = ano::host::calibration_names(*sensor);
        std::ranges::copy(ano::host::calibration_names(ano::host::other_than(*sensor)), std::back_inserter(names));
        next(std::move(task)).read_named(std::move(names), now);
    }
    std::string message() const override { return "restoring the values from before an unfinished calibration"; }
    ano::Fault half_done() const override { return {"will_be_written_back"}; }

private:
    void done(const Task& task, TimePoint now) override {
        if (writes_) return written_back(task);    // CalibrationWrite has read them back
        const std::string* text = place().journal.find(name_);
        const auto sensor = sensor_of_note(name_);
        if (text == nullptr || !sensor) return finish(work_fault({"nothing_saved"}));
        auto values = values_in_note(*text, *sensor);
        if (!values) return finish(work_fault({"saved_damaged", name_}));
        if (const std::string misfit = misfit_of_note(*text, place()); !misfit.empty())
            return finish(work_fault({"saved_unfit", name_, misfit}));
        const auto& parameters = static_cast<const ano::host::Parameters&>(task);
        CalibrationValues has;
        for (auto& [name, value] : *values) {    // the note has them as f32
            const auto* info = parameters.find(name).parameter;
            auto stored = info != nullptr ? parameters.value(info->id) : std::nullopt;
            if (!stored) return finish(work_fault({"parameter_missing", name}));
            has.emplace_back(name, *std::move(stored));
            value = ano::host::nearest_value(value, *info);
        }
        const auto of_other = ano::host::calibration_in(parameters, ano::host::other_than(*sensor));
        const Unit unit = unit_of_note(has, of_other.value_or(CalibrationValues{}), *text, *sensor);
        if (unit == Unit::other) return finish(work_fault(drop_note(place(), name_, unit)));
        if (unit == Unit::alike)
            return finish(work_fault({"saved_for_unknown", ano::Fault{not_distinguishable}, by_hand(place(), name_)}));
        writes_ = true;
        next(std::make_unique<ano::host::CalibrationWrite>(place().device, &place().cache, *sensor, *values)).start(now);
    }

    void written_back(const Task& task) {
        const std::string* text = place().journal.find(name_);
        const std::string kept = text != nullptr ? describe_note(name_, *text) : name_;
        WorkEnd end = end_of(*task.end(), texts());
        Json result{{"written_back", true}, {"kept", kept}};
        if (text != nullptr) result["values"] = note_json(*text).value("parameters", Json{});
        end.result = ano::compact_json(result);
        end.fault = {"restored_unfinished", kept, name_};
        place().journal.forget(name_);
        finish(std::move(end));
    }

    std::string name_;
    bool writes_ = false;
};

class Calibrate final : public TaskWork {
public:
    Calibrate(const WorkPlace& place, Sensor sensor) : TaskWork{place}, sensor_{sensor} {}

    void start(TimePoint now) override {
        auto task = std::make_unique<Calibration>(place().device, sensor_, &place().cache);
        calibration_ = task.get();
        calibration_->ask_before_writing(place().refusal);
        calibration_->keep_before_writing();
        next(std::move(task)).start(now);
    }
    ano::Fault half_done() const override { return kept_where({"the_old_values"}, {"at_next_start"}); }
    void receive(ano::FrameView frame, TimePoint now) override {
        if (calibration_ == nullptr || calibration_->end()) return;
        const Phase before = phase();
        calibration_->receive(frame, now);
        if (phase() != before || calibration_->end()) place().net.wake(now);
    }
    std::optional<TimePoint> due() const override { return calibration_ != nullptr ? calibration_->due() : std::nullopt; }
    bool is_waiting() const override { return phase() == Phase::keep && kept_->is_done && kept_->fault.empty(); }
    bool go_on(TimePoint now) override {
        if (!is_waiting()) return false;
        calibration_->kept(now);
        return true;
    }
    std::string message() const override {
        switch (phase()) {
        case Phase::read: return "reading the old values";
        case Phase::keep:
            return is_waiting() ? "The old values are saved. Continue when you are ready to turn the device"
                                : "saving the old values";
        case Phase::clear: return after_restart("clearing the calibration of the device");
        case Phase::turn:
            return after_restart(sensor_ == Sensor::accelerometer ? "lay it on each of its six faces" : "turn it to all sides");
        case Phase::confirm: return "checking that no sample was corrected";
        case Phase::keep_new: return "saving the new values";
        case Phase::write: return "writing the new values";
        case Phase::verify:
            if (const auto face = calibration_->face_to_verify()) {
                const std::string name{ano::host::name_of(*face)};
                return calibration_->is_further_face() ? "checking the new values: lay it on " + name + " and keep it still"
                                                       : "checking the new values: keep it still on " + name;
            }
            return "checking the new values: keep turning it";
        case Phase::prove:
            return std::string{"the device does not show whether it was cleared, so the new values are checked on all sides: "} +
                   (sensor_ == Sensor::accelerometer ? "lay it on each of its six faces again" : "turn it to all sides again");
        case Phase::restore: return "writing the old values back";
        case Phase::over: break;
        }
        return {};
    }
    std::string step() const override {
        if (calibration_ == nullptr || phase() < Phase::turn || phase() > Phase::prove) return {};
        return (sensor_ == Sensor::accelerometer ? faces_json(calibration_->faces()) : sphere_json(calibration_->sphere()))
            .dump();
    }

private:
    using Phase = Calibration::Step;
    struct Kept {
        bool is_asked = false, is_done = false;
        std::string fault;
    };

    std::string after_restart(std::string message) const {
        if (calibration_->restarts() == 0) return message;
        return "the device restarted (" + calibration_->last_restart().text() + "), so all samples are discarded: " + message;
    }
    Phase phase() const { return calibration_ != nullptr ? calibration_->step() : Phase::read; }
    void look(TimePoint now) override {
        if (end() || calibration_ == nullptr) return;
        calibration_->look(now);
        if (phase() == Phase::turn) keep_cleared();
        if (phase() == Phase::keep_new) keep_new(now);
        if (phase() != Phase::keep) return;
        if (!std::exchange(kept_->is_asked, true)) keep();
        if (is_waiting()) return look_at_clock(now);
        if (kept_->fault.empty()) return;
        calibration_->cancel(now);
        finish(work_fault({"old_values_not_saved", kept_->fault}));
    }
    // Limits the wait, because the job blocks the device meanwhile.
    void look_at_clock(TimePoint now) {
        if (!waits_since_) waits_since_ = now;
        if (now - *waits_since_ < Calibration::time_to_turn) return;
        calibration_->cancel(now);
        forget();
        finish(work_fault({"not_continued"}));
    }
    // Uses the old values stored by an unfinished calibration, not the values that it left in the device.
    bool uses_kept() {
        const std::string name = kept_note(place(), sensor_);
        const auto values = !name.empty() ? values_in_note(*place().journal.find(name), sensor_) : std::nullopt;
        if (!values) return false;
        const Unit unit = unit_of_note(calibration_->old_values(), calibration_->other_values(), *place().journal.find(name),
                                       sensor_);
        if (unit != Unit::same) {
            place().net.report(name + " is not used: " + drop_note(place(), name, unit).text(), true);
            return false;
        }
        note_ = name;
        json_ = note_json(*place().journal.find(name));
        calibration_->set_old_values(*values);
        kept_->is_done = true;
        return true;
    }
    void keep() {
        if (uses_kept()) return;
        note_ = keep_name(place(), sensor_);
        json_ = unit_json(place(), place().device.info());
        json_["parameters"] = values_json(calibration_->old_values());
        json_["bytes"] = bytes_json(calibration_->old_values());
        if (!calibration_->other_values().empty()) json_["other"] = bytes_json(calibration_->other_values());
        keep_note(kept_);
    }
    void keep_note(const std::shared_ptr<Kept>& as) {
        place().journal.keep(note_, ano::compact_json(json_) + "\n", [as, &net = place().net](std::string fault) {
            as->fault = std::move(fault);
            as->is_done = true;
            net.wake(net.now());
        });
    }
    // These and the new values identify the device to which the old values belong.
    void keep_cleared() {
        if (std::exchange(clears_kept_, calibration_->restarts() + 1) == calibration_->restarts() + 1) return;
        json_["cleared"] = bytes_json(calibration_->cleared_values());
        json_.erase("new");
        keep_note(std::make_shared<Kept>());
    }
    void keep_new(TimePoint now) {
        if (!std::exchange(kept_new_->is_asked, true)) {
            json_["new"] = bytes_json(calibration_->new_values());
            keep_note(kept_new_);
        }
        if (!kept_new_->is_done) return;
        if (kept_new_->fault.empty()) calibration_->kept(now);
        else calibration_->not_kept(kept_new_->fault, now);
    }
    void forget() {
        if (!note_.empty()) place().journal.forget(note_);
    }
    // `when`: when the next run of the program writes them back, if it does.
    ano::Fault kept_where(const ano::Fault& what, const ano::Fault& when) const {
        const std::string name = note_.empty() ? keep_name(place(), sensor_) : note_;
        if (const std::string way = place().net.way_to_write_back(name); !way.empty()) return {"saved_as", what, name, way};
        const CalibrationValues left = calibration_ != nullptr ? calibration_->cleared_values() : CalibrationValues{};
        const CalibrationValues other = calibration_ != nullptr ? calibration_->other_values() : CalibrationValues{};
        if (unit_of_note(left, other, ano::compact_json(json_), sensor_) == Unit::same) return {"saved_until", what, name, when};
        return {"saved_by_hand", what, name, ano::Fault{not_distinguishable}, by_hand(place(), name)};
    }
    void done(const Task& task, TimePoint) override {
        forget();
        WorkEnd end = end_of(*task.end(), texts());
        const auto residuals = calibration_->residuals().value_or(std::pair{0.0, 0.0});
        Json result{{"before", residuals.first},
                    {"after", residuals.second},
                    {"verified", calibration_->verified().value_or(residuals.second)},
                    {"restarts", calibration_->restarts()},
                    {"values", values_json(calibration_->new_values())}};
        if (calibration_->keeps_error_matrix()) result["error_matrix"] = "kept";
        end.result = result.dump();
        finish(std::move(end));
    }
    // Deletes the stored values if they are in the device again; otherwise they stay.
    void failed(const Task& task, TimePoint) override {
        WorkEnd end = end_of(*task.end(), texts());
        if (calibration_->has_old_values()) forget();
        else end.fault.add(kept_where({"they"}, {"when_on_ground"}));
        finish(std::move(end));
    }

    Sensor sensor_;
    Calibration* calibration_ = nullptr;
    std::string note_;    // name of the note with the old values
    std::optional<TimePoint> waits_since_;
    std::shared_ptr<Kept> kept_ = std::make_shared<Kept>(), kept_new_ = std::make_shared<Kept>();
    Json json_;    // the note
    unsigned clears_kept_ = 0;
};

}    // namespace

std::unique_ptr<Work> calibrate(const WorkPlace& place, Sensor sensor) { return std::make_unique<Calibrate>(place, sensor); }

std::unique_ptr<Work> write_old_values_back(const WorkPlace& place, const std::string& name) {
    return std::make_unique<WriteBack>(place, name);
}

void forget_written(const WorkPlace& place, const Json& values) {
    for (const Sensor sensor : {Sensor::accelerometer, Sensor::compass}) {
        const std::string name = kept_note(place, sensor);
        const auto kept = !name.empty() ? values_in_note(*place.journal.find(name), sensor) : std::nullopt;
        const auto is_written = [&](const auto& one) {
            const auto value = values.contains(one.first) ? value_in(values[one.first], ano::Type::f32) : std::nullopt;
            return value && ano::host::same_bytes(*value, one.second, ano::Type::f32);
        };
        if (kept && std::all_of(kept->begin(), kept->end(), is_written)) place.journal.forget(name);
    }
}

bool is_whole_backup(const std::string& text, Sensor sensor) { return values_in_note(text, sensor) && info_in_note(text); }

std::string keep_name(const WorkPlace& place, Sensor sensor) {
    return unit_note_name("calibration", place, place.device.info(), name_of(sensor));
}

std::string describe_note(std::string_view name, const std::string& text) {
    const auto sensor = sensor_of_note(name);
    return (sensor ? std::string{name_of(*sensor)} : std::string{name}) + " of " + describe_unit(text);
}

std::optional<Sensor> sensor_of_note(std::string_view name) {
    for (const Sensor sensor : {Sensor::accelerometer, Sensor::compass})
        if (is_unit_note_name(name, "calibration", name_of(sensor))) return sensor;
    return std::nullopt;
}

}    // namespace anogate
