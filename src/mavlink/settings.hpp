// The settings of anogate-mavlink.
#pragma once
#include <gateway/settings.hpp>
#include <mavlink/device_commands.hpp>
#include <mavlink/flight_modes.hpp>
#include <mavlink/mission_items.hpp>
#include <mavlink/stick_control.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Which commands a device has, unless its entry lists them.
enum class CommandSet : std::uint8_t { named, vendor };

struct MavlinkDevice {
    std::uint8_t address = 0xDC;
    std::string link{};         // empty: any
    std::uint8_t system = 1;    // the system id under which stations see it
    std::uint32_t type = 2;     // MAV_TYPE
    std::uint32_t cells = 0;    // of the battery; 0: unknown
    CommandSet commands = CommandSet::named;
    std::vector<mavlink::FunRow> funs = mavlink::usual_funs();
    std::vector<std::string> accept{};    // of mavlink::stick_input_names
    std::uint32_t hover_throttle = 0;     // thousandths of a percent; 0: not set
    std::vector<std::uint8_t> velocity_modes{2}, attitude_modes{0};
    std::vector<std::uint16_t> aux{};    // channels 5 to 10; empty: not set

    mavlink::StickSettings sticks() const;
    std::vector<mavlink::CommandRow> command_rows() const {
        return commands == CommandSet::vendor ? mavlink::vendor_commands() : mavlink::named_commands();
    }
};

struct MavlinkSettings {
    std::string control;                    // the socket of the gateway; empty: searched
    std::vector<std::string> udp;           // HOST:PORT of stations
    std::vector<std::string> udp_listen;    // ADDR:PORT
    std::vector<std::string> tcp_listen;
    std::vector<std::string> serial;    // devices
    std::uint32_t baud = 57'600;
    std::string signing_file;    // with the passphrase for signed packets; empty: packets are not signed
    mavlink::Autopilot autopilot = mavlink::Autopilot::px4;
    std::vector<MavlinkDevice> devices;    // empty: 0xDC as system 1
    LogSettings log;
};

}    // namespace anogate
