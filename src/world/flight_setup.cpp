// The parameters and commands of the simulated flight controller.
#include "flight_controller.hpp"

#include <utility>

namespace ano::world {
namespace {

using device::LogColor;
using device::Parameter;
using device::Value;

constexpr std::size_t waypoints = 50;
constexpr std::array types{Type::u8,  Type::i8,  Type::u16, Type::i16, Type::u32, Type::i32,
                           Type::u64, Type::i64, Type::f32, Type::f64, Type::text};

}    // namespace

void FlightController::add_parameters() {
    add_own_parameters();
    inertial_.add_calibrations(device().parameters(), flight_.hand(), hz(),
                               {[this] { return flight_.may_be_turned(); }, [this] { return store_values(); }});
    add_user_parameters();
    device().parameters().on_save([this] { return store_values(); });
}

void FlightController::add_own_parameters() {
    auto& parameters = device().parameters();
    const auto add = [&](const char* name, auto& variable, const char* info, auto min, auto max) {
        parameters.add(name, variable, {.info = info, .min = min, .max = max});
    };
    add("SIM_MODE", settings_.mode, "0 attitude, 1 and height, 2 and position, 3 programmed", std::uint8_t{0}, std::uint8_t{3});
    add("SIM_TURN", settings_.turn, "turn rate in a hover, degrees per second to the left", std::int8_t{-90}, std::int8_t{90});
    add("SIM_HEIGHT", settings_.height, "hover height, cm: TAKE_OFF 0 climbs to it", std::uint16_t{20}, std::uint16_t{10'000});
    add("SIM_SPEED", settings_.speed, "speed on the way to a point, cm/s", std::uint16_t{20}, std::uint16_t{1000});
    add("SIM_BAR_OFFSET", barometer_offset_, "barometer error, cm", std::int16_t{-1000}, std::int16_t{1000});
    add("SIM_FLIGHT_TIME", settings_.flight_time, "time in a hover until the battery is empty, s", 60u, 86'400u);
    add("SIM_RANGE_OFFSET", range_offset_, "range finder error, cm", -1000, 1000);
    add("SIM_WIND", settings_.wind, "m/s", 0.0f, 8.0f);
    add("SIM_SWAY", settings_.sway, "gusts, % of the wind", 0.0f, 100.0f);
    add("SIM_WIND_FROM", settings_.wind_from, "degrees from north, clockwise", std::uint16_t{0}, std::uint16_t{359});
    add("SIM_HOME_LNG", home_.lng, "longitude of the take-off point, degrees", -180.0, 180.0);
    add("SIM_HOME_LAT", home_.lat, "latitude of the take-off point, degrees", -80.0, 80.0);
    add("SIM_PICTURES", pictures_, "1: sends a moving picture", std::uint8_t{0}, std::uint8_t{1});
    add("SIM_P_POSITION", settings_.gains.position, "1/s", 0.2f, 1.2f);
    add("SIM_P_VELOCITY", settings_.gains.velocity, "1/s", 1.5f, 4.0f);
    add("SIM_P_ATTITUDE", settings_.gains.attitude, "1/s", 3.0f, 10.0f);
    add("SIM_P_RATE", settings_.gains.rate, "1/s", 10.0f, 25.0f);
    parameters.add("SIM_BORN", other_.born, {.info = "seconds since 1970", .min = {}, .max = {}});
    parameters.add("SIM_NOTE", other_.note, {.info = "anything", .max_size = vendor_max_text});
    Parameter serial{.name = "SIM_SERIAL", .type = Type::u64, .initial = other_.serial, .info = "can't be written"};
    serial.get = [this] { return Value{other_.serial}; };
    parameters.add(serial);
    Parameter charge{.name = "SIM_CHARGE", .type = Type::u8, .initial = std::int64_t{100}, .info = "battery charge, %"};
    charge.max = std::int64_t{100};
    charge.get = [this] { return Value{static_cast<std::int64_t>(std::lround(100 * flight_.battery().charge()))}; };
    charge.set = [this](const Value& percent) {
        flight_.battery().charge(device::from_value<double>(percent) / 100);
        return true;
    };
    parameters.add(charge);
}

// Adds parameters up to `parameter_count`, of every type in turn, so that hosts have long lists to read.
void FlightController::add_user_parameters() {
    auto& parameters = device().parameters();
    other_.user.reserve(parameter_count);
    while (parameters.count() < parameter_count) {
        const std::size_t n = other_.user.size();
        const Type type = types[n % types.size()];
        Value& value = other_.user.emplace_back(device::zero_of(type));
        const std::string number = std::to_string(n);
        Parameter row{.name = "USER_" + std::string(number.size() < 2 ? 1 : 0, '0') + number, .type = type, .initial = value};
        row.info = "anything";
        row.max_size = 20;
        row.get = [&value] { return value; };
        row.set = [&value](const Value& v) { return value = v, true; };
        parameters.add(std::move(row));
    }
}

void FlightController::add_commands() {
    auto& commands = device().commands();
    add_flights();
    commands.add({0x10, 0, 5}, "ADD", "reports the sum of its values",
                 [this](std::uint8_t a, std::int8_t b, std::uint16_t c, std::int16_t d, std::uint32_t e, std::int32_t f, float g,
                        double h) {
                     const double sum = a + b + c + d + static_cast<double>(e) + f + double{g} + h;
                     device().log(static_cast<float>(sum), "is the sum");
                 });
    commands.add({0x10, 0, 6}, "UNLOCK", "", [this] { return flight_.unlock(); });
    commands.add({0x10, 0, 7}, "LOCK", "on the ground", [this] { return flight_.lock(); });
    commands.add({0x10, 0, 11}, "MODE", "as SIM_MODE", [this](std::uint8_t mode) {
        return mode <= 3 && device().parameters().write("SIM_MODE", Value{std::int64_t{mode}});
    });
}

// 0x06 reports a command that takes a while until it is done.
void FlightController::add_flights() {
    auto& commands = device().commands();
    commands.add(command_of(Flight::Task::take_off), "TAKE_OFF", "height in cm; 0: SIM_HEIGHT",
                 [this](std::uint16_t height) { return flight_.take_off((height == 0 ? settings_.height : height) / 100.0); });
    commands.add(command_of(Flight::Task::land), "LAND", "", [this] { return flight_.land(); });
    commands.add({0x10, 0, 3}, "TURN", "degrees per second, in a hover",
                 [this](std::int8_t turn) { return device().parameters().write("SIM_TURN", Value{std::int64_t{turn}}); });
    commands.add(command_of(Flight::Task::hover), "HOVER", "stays where it is", [this] { return flight_.hover(); });
    commands.add(command_of(Flight::Task::go_to), "GO_TO", "cm from take-off: north, west, up",
                 [this](std::int64_t x, std::int64_t y, std::uint16_t z) {
                     return flight_.go_to({static_cast<double>(x) / 100, static_cast<double>(y) / 100, z / 100.0});
                 });
    commands.add(command_of(Flight::Task::yaw), "YAW", "degrees to the left of north",
                 [this](std::int16_t yaw) { return flight_.yaw(yaw * degree); });
    commands.add(command_of(Flight::Task::return_home), "RETURN_HOME", "returns and lands",
                 [this] { return flight_.return_home(); });
    commands.add(command_of(Flight::Task::route), "WAYPOINTS", "from this waypoint on",
                 [this](std::uint8_t first) { return fly_waypoints(first); });
}

void FlightController::add_waypoints() {
    device().waypoints().allow(waypoints);
    device().waypoints().resize(1);
    device::Waypoint home;
    home.lng = home_.lng;
    home.lat = home_.lat;
    device().waypoints().set(0, home);
}

Vector FlightController::place_of(const device::Waypoint& w) const noexcept {
    return from_home({w.lng, w.lat}, home_) + Vector{0, 0, w.alt / 100.0};
}

// The protocol text (section 4) leaves the meaning of `fun` to the device. Here the vehicle stays for cmd1 seconds if `fun` is 1,
// and does not stay otherwise.
RoutePoint FlightController::route_point(const device::Waypoint& w) const noexcept {
    constexpr std::uint16_t to_the_target = 400;
    constexpr std::uint8_t stay = 1;
    RoutePoint point{.there = place_of(w), .speed = w.spd / 100.0};
    if (w.yaw != to_the_target) point.yaw = wrapped(-w.yaw * degree);
    if (w.fun == stay) point.stay = w.cmd[0];
    return point;
}

bool FlightController::fly_waypoints(std::uint8_t first) {
    const auto& all = device().waypoints();
    std::vector<RoutePoint> route;
    for (std::size_t n = first; n < all.count(); ++n) route.push_back(route_point(all[n]));
    return flight_.fly(std::move(route));
}

}    // namespace ano::world
