#include <ano/address.hpp>
#include <device/parameters.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace ano::device {
namespace {

// cmd of 0xE0
constexpr std::uint8_t cmd_count = 1;
constexpr std::uint8_t cmd_value = 2;
constexpr std::uint8_t cmd_describe = 3;

constexpr std::uint8_t par_type_text = 10;
constexpr std::size_t max_parameters = UINT16_MAX;    // both an id and the count are u16

std::uint8_t par_type_of(Type type) noexcept { return type == Type::text ? par_type_text : static_cast<std::uint8_t>(type); }

Value clamped(const Parameter& row, Value value) {
    if (row.type == Type::text) {
        auto& text = std::get<std::string>(value);
        if (text.size() > row.max_size) text.resize(row.max_size);
        return value;
    }
    if (value < *row.min) return *row.min;
    if (*row.max < value) return *row.max;
    return value;
}

void refuse_unless(bool sensible, const Parameter& row, const char* why) {
    if (!sensible) throw std::invalid_argument{"parameter \"" + row.name + "\": " + why};
}

}    // namespace

std::uint16_t Parameters::add(Parameter row) {
    refuse_unless(!row.name.empty() && row.name.size() <= max_name, row, "a name has 1 to 20 bytes");
    refuse_unless(!find(row.name), row, "there is one of this name");
    refuse_unless(rows_.size() < max_parameters, row, "there are 65535 already");
    refuse_unless(is_number(row.type) || row.type == Type::text, row, "its type is neither a number nor text");
    refuse_unless(!row.name.starts_with("CAL_") || row.type == Type::f32, row, "a calibration parameter is f32");
    refuse_unless(static_cast<bool>(row.get), row, "without get it has no value");
    if (row.type == Type::text) {
        row.max_size = std::min(row.max_size, profile_.max_string);
    } else {
        const auto [first, last] = range_of(row.type);
        if (!row.min) row.min = first;
        if (!row.max) row.max = last;
        const bool of_type = fits(*row.min, row.type) && fits(*row.max, row.type);
        refuse_unless(of_type && *row.min <= *row.max, row, "its limits are no range of its type");
    }
    refuse_unless(fits(row.initial, row.type), row, "its default is no value of its type");
    refuse_unless(clamped(row, row.initial) == row.initial, row, "its default is beyond its limits");
    rows_.push_back(std::move(row));
    return static_cast<std::uint16_t>(rows_.size() - 1);
}

std::optional<std::uint16_t> Parameters::find(std::string_view name) const noexcept {
    const auto row = std::find_if(rows_.begin(), rows_.end(), [&](const Parameter& r) { return r.name == name; });
    if (row == rows_.end()) return std::nullopt;
    return static_cast<std::uint16_t>(row - rows_.begin());
}

bool Parameters::write(std::string_view name, const Value& value) {
    const auto id = find(name);
    return id && value.index() == rows_[*id].initial.index() && assign(rows_[*id], value);
}

bool Parameters::restore_defaults(std::string_view beginning) {
    bool done = true;
    for (const Parameter& row : rows_)
        if (row.name.starts_with(beginning) && row.set) done = row.set(row.initial) && done;
    return done;
}

// NaN is refused, since it can't be compared with limits.
bool Parameters::assign(const Parameter& row, const Value& value) const {
    if (!row.set || is_nan(value)) return false;
    Value allowed = clamped(row, value);
    if (profile_.refuses_beyond_limits && allowed != value) return false;
    return row.set(allowed);
}

bool Parameters::has(std::uint16_t id) {
    if (profile_.crashes_at_the_count && id == rows_.size()) crashed_ = true;
    return id < rows_.size();
}

Outcome Parameters::process(const View<"parameter_command">& question, Reply& reply) {
    const std::uint16_t val = question.get<"val">();
    switch (question.get<"cmd">()) {
    case cmd_count: return send_count(question, reply);
    case cmd_value: return has(val) ? send_value(val, reply) : Outcome::unknown;
    case cmd_describe: return has(val) ? describe(val, reply) : Outcome::unknown;
    default: return Outcome::unknown;
    }
}

// The answer has the form of the question, so two devices would answer each other forever. Therefore only a host may ask with any
// val (which has no meaning in the protocol text), and only a host gets the answer that there are no parameters.
Outcome Parameters::send_count(const View<"parameter_command">& question, Reply& reply) {
    const bool asked_by_host = reply.asker().address == address::host;
    if (!asked_by_host && (question.get<"val">() != 0 || rows_.empty())) return Outcome::unanswered;
    Draft<"parameter_command"> answer;
    if (!answer.set<"cmd">(cmd_count) || !answer.set<"val">(rows_.size())) return Outcome::unknown;
    return reply.send(answer);
}

Outcome Parameters::send_value(std::uint16_t id, Reply& reply) {
    const Parameter& row = rows_[id];
    const Value value = row.get();
    if (value.index() != row.initial.index()) return Outcome::refused;    // `get` returned another type
    bytes_.clear();
    if (profile_.sends_i32()) append_value(bytes_, Type::i32, std::int64_t{as_i32(value, factor_of(row))});
    else append_value(bytes_, row.type, value);
    Draft<"parameter_value"> answer;
    const std::size_t max_size = max_sent - answer.data_size();
    if (!answer.set<"par_id">(id) || !answer.set<"value">(Bytes{bytes_}.first(std::min(bytes_.size(), max_size))))
        return Outcome::unknown;
    return reply.send(answer);
}

Outcome Parameters::describe(std::uint16_t id, Reply& reply) {
    if (profile_.old_layouts) return send_old_description(id, reply);
    if (profile_.scaled_values) return send_scaled_description(id, reply);
    const Parameter& row = rows_[id];
    Draft<"parameter_info"> answer;
    const bool all = answer.set<"par_id">(id) && answer.set<"par_type">(par_type_of(row.type)) &&
                     answer.set<"name">(std::string_view{row.name}) &&
                     answer.set<"info">(what_fits(row.info, answer.data_size()));
    return all ? reply.send(answer) : Outcome::unknown;
}

Outcome Parameters::send_old_description(std::uint16_t id, Reply& reply) const {
    const Parameter& row = rows_[id];
    Draft<"parameter_info", "old"> answer;
    const bool is_text = row.type == Type::text;
    const bool all = answer.set<"par_id">(id) && answer.set<"min">(is_text ? 0 : as_i32(*row.min)) &&
                     answer.set<"max">(is_text ? 0 : as_i32(*row.max)) && answer.set<"name">(std::string_view{row.name}) &&
                     answer.set<"info">(what_fits(row.info, answer.data_size()));
    return all ? reply.send(answer) : Outcome::unknown;
}

// The range is that of the value without the factor.
Outcome Parameters::send_scaled_description(std::uint16_t id, Reply& reply) const {
    const Parameter& row = rows_[id];
    const bool is_text = row.type == Type::text;
    Draft<"parameter_info", "scaled"> answer;
    const auto limit = [&](const Value& value, double (*rounded)(double)) {
        const auto* const real = std::get_if<double>(&value);
        return as_i32(real != nullptr ? Value{rounded(*real)} : value);
    };
    const bool all = answer.set<"par_id">(id) && answer.set<"min">(is_text ? 0 : limit(*row.min, std::floor)) &&
                     answer.set<"max">(is_text ? 0 : limit(*row.max, std::ceil)) &&
                     answer.set<"mul">(factor_of(row) == 1 ? 0 : factor_of(row)) &&
                     answer.set<"name">(std::string_view{row.name}) &&
                     answer.set<"info">(what_fits(row.info, answer.data_size()));
    return all ? reply.send(answer) : Outcome::unknown;
}

// The factor by which the value is multiplied in 0xE1.
std::int32_t Parameters::factor_of(const Parameter& row) const noexcept {
    const bool is_real = row.type == Type::f32 || row.type == Type::f64;
    if (!profile_.scaled_values || !is_real) return 1;
    return row.type == Type::f64 || row.name.starts_with("CAL_") ? 1'000'000 : 1000;
}

Outcome Parameters::process(const View<"parameter_value">& written, Reply& reply) {
    const std::uint16_t id = written.get<"par_id">();
    if (!has(id)) return profile_.acknowledges_unknown && !crashed_ ? reply.acknowledge() : Outcome::unknown;
    const Parameter& row = rows_[id];
    const auto value = value_written(row, written, reply.request());
    if (!value) return Outcome::malformed;
    return assign(row, *value) ? reply.acknowledge() : Outcome::refused;
}

std::optional<Value> Parameters::value_written(const Parameter& row, const View<"parameter_value">& written,
                                               FrameView frame) const {
    if (profile_.sends_i32() && row.type == Type::text) return std::nullopt;
    const Type type = profile_.sends_i32() ? Type::i32 : row.type;
    const Bytes bytes = written.get<"value">();
    std::array<std::uint8_t, sizeof(std::uint64_t)> filled{};
    const auto value = [&](Bytes whole) {
        if (!profile_.sends_i32()) return read_value(type, whole);
        return from_i32(row.type, from_value<std::int32_t>(read_value(type, whole)), factor_of(row));
    };
    if (is_whole_value(bytes.size(), type)) return value(bytes);
    if (!profile_.reads_behind_the_end || type == Type::text) return std::nullopt;
    const Bytes to_the_end = frame.bytes().last(bytes.size() + 2);    // including SC and AC after it
    std::copy_n(to_the_end.begin(), std::min(to_the_end.size(), filled.size()), filled.begin());
    return value(filled);
}

bool Parameters::has_calibration(std::string_view beginning) const noexcept {
    return std::any_of(rows_.begin(), rows_.end(), [&](const Parameter& row) { return row.name.starts_with(beginning); });
}

Outcome Parameters::process(const View<"parameter_command", "action">& action, Reply& reply) {
    bool known = true;
    const bool done = act(action.get<"val">(), known);
    if (!known) return Outcome::unknown;
    return done ? reply.acknowledge() : Outcome::refused;
}

bool Parameters::act(std::uint16_t action, bool& known) {
    if (const auto own = actions_.find(action); own != actions_.end() && own->second) return own->second();
    const auto of_calibration = [&](std::string_view beginning, auto what) {
        known = has_calibration(beginning);
        return known && what(beginning);
    };
    const auto clear = [&](std::string_view beginning) { return restore_defaults(beginning); };
    const auto save = [&](std::string_view) { return act(static_cast<std::uint16_t>(Action::save), known); };
    switch (Action{action}) {
    case Action::restore_defaults: known = !rows_.empty(); return known && restore_defaults();
    case Action::clear_accelerometer: return of_calibration("CAL_A", clear);
    case Action::store_accelerometer: return of_calibration("CAL_A", save);
    case Action::clear_compass: return of_calibration("CAL_M", clear);
    case Action::store_compass: return of_calibration("CAL_M", save);
    default: known = false; return false;    // also Action::save, which needs a function of the user
    }
}

}    // namespace ano::device
