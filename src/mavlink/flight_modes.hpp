// Flight modes as ground stations know them (custom_mode of HEARTBEAT), for the kinds of autopilot that a device can be shown as.
#pragma once
#include <mavlink/vehicle_state.hpp>

#include <cstdint>
#include <optional>
#include <string_view>

namespace anogate::mavlink {

/// As which autopilot a device is shown. Ground stations offer actions by it.
enum class Autopilot : std::uint8_t { generic, px4, ardupilot };
inline constexpr std::string_view autopilot_names[] = {"generic", "px4", "ardupilot"};    // in the order of Autopilot

/// MAV_AUTOPILOT.
std::uint8_t number_of(Autopilot autopilot) noexcept;

/// What a vehicle does, as far as a ground station distinguishes it.
enum class Activity : std::uint8_t {
    attitude,    // the flight modes of 0x06, without a command
    height,
    position,
    programmed,
    take_off,    // commands that are being executed
    land,
    return_home,
    go_to,
    mission,
    hold,
};

/// custom_mode of HEARTBEAT.
std::uint32_t custom_mode(Autopilot autopilot, Activity activity) noexcept;
/// The activity that a ground station selects by `custom_mode`; std::nullopt: there is no such mode, or it can't be selected.
std::optional<Activity> activity_of(Autopilot autopilot, std::uint32_t custom_mode) noexcept;

}    // namespace anogate::mavlink
