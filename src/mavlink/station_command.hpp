// Commands of ground stations (COMMAND_LONG, COMMAND_INT, SET_MODE), and what they ask of a device. No I/O, no clock.
#pragma once
#include <mavlink/device_commands.hpp>
#include <mavlink/flight_modes.hpp>
#include <mavlink/packet.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

namespace anogate::mavlink {

/// MAV_RESULT.
enum class Result : std::uint8_t { accepted, temporarily_rejected, denied, unsupported, failed, in_progress };

/// MAV_CMD.
enum class Command : std::uint16_t {
    nav_waypoint = 16,
    nav_loiter_unlimited = 17,
    nav_return_to_launch = 20,
    nav_land = 21,
    nav_takeoff = 22,
    condition_yaw = 115,
    do_set_mode = 176,
    do_change_speed = 178,
    do_reposition = 192,
    do_pause_continue = 193,
    preflight_calibration = 241,
    preflight_reboot = 246,
    mission_start = 300,
    arm_disarm = 400,
    get_home_position = 410,
    get_message_interval = 510,
    set_message_interval = 511,
    request_message = 512,
    request_protocol_version = 519,
    request_capabilities = 520,
};

struct StationCommand {
    Origin from{};
    std::uint8_t target_system = 0, target_component = 0;
    std::uint16_t command = 0;
    std::array<double, 7> parameters{};     // positions in degrees; NaN: not stated
    std::uint8_t confirmation = 0;          // how often the station repeated it
    std::optional<std::uint8_t> frame{};    // MAV_FRAME, of COMMAND_INT

    bool is_same(const StationCommand& other) const noexcept;
};
/// std::nullopt: it is another message.
std::optional<StationCommand> station_command(PacketView packet) noexcept;

/// What is known of the vehicle.
struct CommandContext {
    Autopilot autopilot = Autopilot::generic;
    std::optional<Home> home{};
    std::optional<Vector> position{};    // NED, from home
};

/// The wish for a device; or the result, if the command can't be expressed. `unsupported`, too, for what the program answers by
/// itself, such as request_message.
std::variant<Wish, Result> wish_of(const StationCommand& command, const CommandContext& context) noexcept;

}    // namespace anogate::mavlink
