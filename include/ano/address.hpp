// Hardware ids (protocol text, section 2).
#pragma once
#include <cstdint>
#include <string_view>

namespace ano::address {

inline constexpr std::uint8_t unassigned = 0x00;    // never a valid source or destination
inline constexpr std::uint8_t last_port_id = 20;    // 1 to 20 are the ports of a device
inline constexpr std::uint8_t ros_bridge = 0xD2;
inline constexpr std::uint8_t flight_controller = 0xDC;
inline constexpr std::uint8_t data_radio = 0xE6;
inline constexpr std::uint8_t host = 0xFE;
inline constexpr std::uint8_t broadcast = 0xFF;    // never a source

constexpr bool is_port_id(std::uint8_t a) noexcept { return a >= 1 && a <= last_port_id; }

/// No device has it: such a source does not identify the sender.
constexpr bool is_nobody(std::uint8_t a) noexcept { return a == unassigned || a == broadcast; }

/// Several hosts may share these; a host may receive for hours without sending.
constexpr bool is_host(std::uint8_t a) noexcept { return a == host || a == ros_bridge; }

/// The usual owner of this id, as text for people.
constexpr std::string_view who(std::uint8_t a) noexcept {
    switch (a) {
    case 0x00: return "unassigned";
    case 0xD0: return "power unit";
    case 0xD2: return "ROS 2 bridge";
    case 0xDB: return "vendor MCU";
    case 0xDC: return "flight controller";
    case 0xDD: return "IMU";
    case 0xDE: return "optical flow";
    case 0xDF: return "OpenMV camera";
    case 0xE6: return "data radio";
    case 0xFD: return "protocol simulator";
    case 0xFE: return "host";
    case 0xFF: return "broadcast";
    default: return is_port_id(a) ? "port" : a < 200 ? "user device" : "reserved";
    }
}

}    // namespace ano::address
