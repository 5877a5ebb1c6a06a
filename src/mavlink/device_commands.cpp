#include <mavlink/device_commands.hpp>

#include <ano/wire.hpp>

#include <cmath>

namespace anogate::mavlink {
namespace {

using ano::Type;

double value_of(Variable variable, const Wish& wish) noexcept {
    constexpr double cm = 100, unit = 1e7, turn = 360;
    switch (variable) {
    case Variable::height_cm: return cm * wish.height;
    case Variable::north_cm: return cm * wish.north;
    case Variable::west_cm: return cm * wish.west;
    case Variable::up_cm: return cm * wish.up;
    case Variable::heading: return std::fmod(wish.heading + turn, turn);
    case Variable::left_of_north: return std::remainder(-wish.heading, turn);
    case Variable::speed_cm: return cm * wish.speed;
    case Variable::mode: return wish.mode;
    case Variable::first: return wish.first;
    case Variable::lat_1e7: return unit * wish.lat;
    case Variable::lng_1e7: return unit * wish.lng;
    }
    return 0;
}

// Rounded for an integer; std::nullopt: it does not fit.
std::optional<double> fitted(Type type, double value) noexcept {
    if (!std::isfinite(value)) return std::nullopt;
    return ano::with_type(type, [&]<class T>(T) -> std::optional<double> {
        if constexpr (std::is_floating_point_v<T>) return value;
        const double whole = std::round(value);
        if (whole < static_cast<double>(std::numeric_limits<T>::lowest()) ||
            whole > static_cast<double>(std::numeric_limits<T>::max()))
            return std::nullopt;
        return whole + 0.0;    // no -0
    });
}

CommandValue variable(Type type, Variable which) { return {type, which, 0}; }
CommandValue constant(Type type, double value) { return {type, std::nullopt, value}; }

}    // namespace

std::vector<CommandRow> named_commands() {
    return {
        {Action::arm, "UNLOCK", {}, {}},
        {Action::disarm, "LOCK", {}, {}},
        {Action::take_off, "TAKE_OFF", {}, {variable(Type::u16, Variable::height_cm)}},
        {Action::land, "LAND", {}, {}},
        {Action::return_home, "RETURN_HOME", {}, {}},
        {Action::hold, "HOVER", {}, {}},
        {Action::go_to,
         "GO_TO",
         {},
         {variable(Type::i64, Variable::north_cm), variable(Type::i64, Variable::west_cm), variable(Type::u16, Variable::up_cm)}},
        {Action::yaw, "YAW", {}, {variable(Type::i16, Variable::left_of_north)}},
        {Action::set_mode, "MODE", {}, {variable(Type::u8, Variable::mode)}},
        {Action::start_mission, "WAYPOINTS", {}, {variable(Type::u8, Variable::first)}}};
}

std::vector<CommandRow> vendor_commands() {
    return {{Action::arm, "", Cid{0x10, 0, 0x01}, {}},
            {Action::stop, "", Cid{0x10, 0, 0x02}, {}},
            {Action::hold, "", Cid{0x10, 0, 0x04}, {}},
            {Action::take_off, "", Cid{0x10, 0, 0x05}, {variable(Type::u16, Variable::height_cm)}},
            {Action::land, "", Cid{0x10, 0, 0x06}, {}},
            {Action::return_home, "", Cid{0x10, 0, 0x07}, {}},
            {Action::start_mission, "", Cid{0x10, 0, 0x60}, {constant(Type::u8, 0)}},
            {Action::clear_mission, "", Cid{0x01, 0, 0x62}, {}},
            {Action::set_mode, "", Cid{0x01, 0x01, 0x01}, {variable(Type::u8, Variable::mode)}}};
}

const CommandRow* find_row(std::span<const CommandRow> rows, Action action) noexcept {
    for (const CommandRow& row : rows)
        if (row.action == action) return &row;
    return nullptr;
}

std::optional<DeviceCommand> command_for(const CommandRow& row, const Wish& wish) {
    DeviceCommand command{row.name, row.cid, {}};
    for (const CommandValue& value : row.values) {
        const auto number = fitted(value.type, value.variable ? value_of(*value.variable, wish) : value.constant);
        if (!number) return std::nullopt;
        command.values.push_back({value.type, *number});
    }
    return command;
}

}    // namespace anogate::mavlink
