#include <mavlink/station_command.hpp>
#include <mavlink/typed.hpp>

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace anogate::mavlink {
namespace {

using Answer = std::variant<Wish, Result>;
using Parameters = std::array<double, 7>;

constexpr double degree_unit = 1e-7;

Wish wish(Action action) noexcept {
    Wish result;
    result.action = action;
    return result;
}

double degrees_of(std::int32_t value) noexcept {
    return value == std::numeric_limits<std::int32_t>::max() ? std::numeric_limits<double>::quiet_NaN() : value * degree_unit;
}

// The height above home of an altitude, by the frame of COMMAND_INT or the habit of the autopilot; std::nullopt: it is not known.
std::optional<double> height_above_home(double altitude, const StationCommand& command, const CommandContext& context) noexcept {
    constexpr std::uint8_t global = 0, relative = 3, global_int = 5, relative_int = 6;
    const std::uint8_t usual = context.autopilot == Autopilot::ardupilot ? relative : global;
    const std::uint8_t frame = command.frame.value_or(usual);
    if (frame == relative || frame == relative_int) return altitude;
    if ((frame != global && frame != global_int) || !context.home) return std::nullopt;
    return altitude - context.home->altitude;
}

Answer arm_or_disarm(const Parameters& p) noexcept {
    constexpr double force = 21'196;
    if (p[0] == 1) return wish(Action::arm);
    if (p[0] == 0) return wish(p[1] == force ? Action::stop : Action::disarm);
    return Result::denied;
}

Answer take_off(const StationCommand& command, const CommandContext& context) noexcept {
    Wish result = wish(Action::take_off);
    if (std::isnan(command.parameters[6])) return result;
    const auto height = height_above_home(command.parameters[6], command, context);
    if (!height || !(*height > 0)) return Result::denied;
    result.height = *height;
    return result;
}

Answer yaw_to(double heading) noexcept {
    Wish result = wish(Action::yaw);
    result.heading = heading;
    return result;
}

// Parts that are not stated stay as they are.
Answer reposition(const StationCommand& command, const CommandContext& context) noexcept {
    const Parameters& p = command.parameters;
    const bool has_place = !std::isnan(p[4]) && !std::isnan(p[5]), has_altitude = !std::isnan(p[6]);
    if (std::isnan(p[4]) != std::isnan(p[5])) return Result::denied;
    if (!has_place && !has_altitude) {
        if (std::isnan(p[3])) return wish(Action::hold);
        // QGroundControl sends radians to PX4, degrees are in the definition of ArduPilot.
        return yaw_to(context.autopilot == Autopilot::ardupilot ? p[3] : p[3] * 180 / std::numbers::pi);
    }
    if (!context.home || !context.position) return Result::temporarily_rejected;
    Wish result = wish(Action::go_to);
    result.north = context.position->x;
    result.west = -context.position->y;
    result.up = -context.position->z;
    result.lat = p[4];
    result.lng = p[5];
    if (has_place) {
        if (std::abs(p[4]) > 90 || std::abs(p[5]) > 180) return Result::denied;
        const double lat = context.home->lat * degree_unit, lng = context.home->lng * degree_unit;
        result.north = (p[4] - lat) * metres_per_degree;
        result.west = (lng - p[5]) * metres_per_degree * std::cos(lat * std::numbers::pi / 180);
    }
    if (has_altitude) {
        const auto height = height_above_home(p[6], command, context);
        if (!height) return Result::denied;
        result.up = *height;
    }
    return result;
}

// Direction and relative angles are not expressed by devices.
Answer turn(const Parameters& p) noexcept {
    if (p[3] != 0 || std::isnan(p[0])) return Result::denied;
    return yaw_to(p[0]);
}

Answer change_speed(const Parameters& p) noexcept {
    if (!(p[1] > 0) || p[2] > 0 || p[3] != 0) return Result::denied;
    Wish result = wish(Action::change_speed);
    result.speed = p[1];
    return result;
}

Answer set_mode(const Parameters& p, const CommandContext& context) noexcept {
    constexpr unsigned custom = 1;
    const auto whole = [](double value) {
        return value >= 0 && value <= std::numeric_limits<std::uint32_t>::max() ? static_cast<std::uint32_t>(value) : 0;
    };
    if ((whole(p[0]) & custom) == 0) return Result::unsupported;
    const std::uint32_t number = context.autopilot == Autopilot::px4 ? whole(p[1]) << 16 | whole(p[2]) << 24 : whole(p[1]);
    const auto activity = activity_of(context.autopilot, number);
    if (!activity) return Result::unsupported;
    switch (*activity) {
    case Activity::take_off: return wish(Action::take_off);
    case Activity::land: return wish(Action::land);
    case Activity::return_home: return wish(Action::return_home);
    case Activity::mission: return wish(Action::start_mission);
    case Activity::go_to:
    case Activity::hold: return wish(Action::hold);
    default:
        Wish result = wish(Action::set_mode);
        result.mode = static_cast<std::uint8_t>(*activity);
        return result;
    }
}

Answer calibrate(const Parameters& p) noexcept {
    if (p[0] == 1) return wish(Action::calibrate_gyro);
    if (p[1] == 1) return wish(Action::calibrate_compass);
    return p[4] == 1 ? Answer{wish(Action::calibrate_accelerometer)} : Result::unsupported;
}

Answer start_mission(const Parameters& p) noexcept {
    Wish result = wish(Action::start_mission);
    constexpr double last = 0xFE;
    if (p[0] > 0 && p[0] <= last) result.first = static_cast<std::uint8_t>(p[0]);
    return result;
}

}    // namespace

bool StationCommand::is_same(const StationCommand& other) const noexcept {
    for (std::size_t i = 0; i < parameters.size(); ++i)
        if (std::bit_cast<std::uint64_t>(parameters[i]) != std::bit_cast<std::uint64_t>(other.parameters[i])) return false;
    return from == other.from && command == other.command && frame == other.frame;
}

std::optional<StationCommand> station_command(PacketView packet) noexcept {
    const Origin from{packet.system(), packet.component()};
    if (const auto c = as<"COMMAND_LONG">(packet))
        return StationCommand{from,
                              c->get<"target_system">(),
                              c->get<"target_component">(),
                              c->get<"command">(),
                              {c->get<"param1">(), c->get<"param2">(), c->get<"param3">(), c->get<"param4">(), c->get<"param5">(),
                               c->get<"param6">(), c->get<"param7">()},
                              c->get<"confirmation">(),
                              std::nullopt};
    if (const auto c = as<"COMMAND_INT">(packet))
        return StationCommand{from,
                              c->get<"target_system">(),
                              c->get<"target_component">(),
                              c->get<"command">(),
                              {c->get<"param1">(), c->get<"param2">(), c->get<"param3">(), c->get<"param4">(),
                               degrees_of(c->get<"x">()), degrees_of(c->get<"y">()), c->get<"z">()},
                              0,
                              c->get<"frame">()};
    if (const auto c = as<"SET_MODE">(packet)) {
        const std::uint32_t mode = c->get<"custom_mode">();
        StationCommand command{from,        c->get<"target_system">(), 0, static_cast<std::uint16_t>(Command::do_set_mode), {}, 0,
                               std::nullopt};
        // As DO_SET_MODE has it: PX4 in two parts, others in one.
        const bool is_px4 = mode >= 1u << 16;
        command.parameters = {static_cast<double>(c->get<"base_mode">()), static_cast<double>(is_px4 ? mode >> 16 & 0xFFu : mode),
                              static_cast<double>(is_px4 ? mode >> 24 : 0)};
        return command;
    }
    return std::nullopt;
}

std::variant<Wish, Result> wish_of(const StationCommand& command, const CommandContext& context) noexcept {
    const Parameters& p = command.parameters;
    switch (static_cast<Command>(command.command)) {
    case Command::arm_disarm: return arm_or_disarm(p);
    case Command::nav_takeoff: return take_off(command, context);
    case Command::nav_land: return wish(Action::land);
    case Command::nav_return_to_launch: return wish(Action::return_home);
    case Command::nav_loiter_unlimited: return wish(Action::hold);
    case Command::do_pause_continue: return p[0] == 0 ? std::variant<Wish, Result>{wish(Action::hold)} : Result::unsupported;
    case Command::do_reposition: return reposition(command, context);
    case Command::condition_yaw: return turn(p);
    case Command::do_change_speed: return change_speed(p);
    case Command::do_set_mode: return set_mode(p, context);
    case Command::preflight_calibration: return calibrate(p);
    case Command::preflight_reboot: return p[0] == 1 ? std::variant<Wish, Result>{wish(Action::reboot)} : Result::unsupported;
    case Command::mission_start: return start_mission(p);
    default: return Result::unsupported;
    }
}

}    // namespace anogate::mavlink
