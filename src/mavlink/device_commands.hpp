// Which command of a device carries out what a ground station wants: a table, with defaults for devices that describe their commands by
// name (as sim:fc) and for the vendor's numbers.
#pragma once
#include <ano/schema.hpp>
#include <mavlink/vehicle_state.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::mavlink {

/// What a station can want.
enum class Action : std::uint8_t {
    arm,
    disarm,
    stop,    // the motors, also in the air
    take_off,
    land,
    return_home,
    hold,
    go_to,
    yaw,
    change_speed,
    set_mode,
    start_mission,
    clear_mission,
    calibrate_gyro,
    calibrate_compass,
    calibrate_accelerometer,
    reboot,
};
inline constexpr std::string_view action_names[] = {"arm",
                                                    "disarm",
                                                    "stop",
                                                    "take_off",
                                                    "land",
                                                    "return_home",
                                                    "hold",
                                                    "go_to",
                                                    "yaw",
                                                    "change_speed",
                                                    "set_mode",
                                                    "start_mission",
                                                    "clear_mission",
                                                    "calibrate_gyro",
                                                    "calibrate_compass",
                                                    "calibrate_accelerometer",
                                                    "reboot"};    // in the order of Action

/// What a value of a command means, in its unit.
enum class Variable : std::uint8_t {
    height_cm,
    north_cm,
    west_cm,
    up_cm,
    heading,
    left_of_north,
    speed_cm,
    mode,
    first,
    lat_1e7,
    lng_1e7
};
inline constexpr std::string_view variable_names[] = {"height_cm", "north_cm", "west_cm", "up_cm",   "heading", "left_of_north",
                                                      "speed_cm",  "mode",     "first",   "lat_1e7", "lng_1e7"};

struct CommandValue {
    ano::Type type = ano::Type::u8;
    std::optional<Variable> variable{};    // std::nullopt: `constant`
    double constant = 0;
    bool operator==(const CommandValue&) const = default;
};

struct CommandRow {
    Action action{};
    std::string name{};          // as the device describes it
    std::optional<Cid> cid{};    // used instead of the name
    std::vector<CommandValue> values{};
    bool operator==(const CommandRow&) const = default;
};

/// Commands by name, as sim:fc has them.
std::vector<CommandRow> named_commands();
/// The numbers of the vendor's flight controllers.
std::vector<CommandRow> vendor_commands();

/// The wish of a station, with those values that the action needs. SI units, degrees.
struct Wish {
    Action action{};
    double height = 0;                     // above the take-off point; 0: the usual one
    double north = 0, west = 0, up = 0;    // from the take-off point
    double heading = 0;                    // clockwise from north
    double speed = 0;
    std::uint8_t mode = 0;
    std::uint8_t first = 1;    // waypoint
    double lat = 0, lng = 0;
};

struct CommandNumber {
    ano::Type type{};
    double value = 0;
    bool operator==(const CommandNumber&) const = default;
};
struct DeviceCommand {
    std::string name{};
    std::optional<Cid> cid{};
    std::vector<CommandNumber> values{};
    bool operator==(const DeviceCommand&) const = default;
};

/// nullptr: the device has no such command.
const CommandRow* find_row(std::span<const CommandRow> rows, Action action) noexcept;
/// std::nullopt: a value does not fit its type.
std::optional<DeviceCommand> command_for(const CommandRow& row, const Wish& wish);

}    // namespace anogate::mavlink
