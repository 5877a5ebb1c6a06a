// The keys of mavlink.json.
#include <ano_json/nearest.hpp>
#include <config/key_rows.hpp>
#include <config/values.hpp>
#include <mavlink/mavlink_config.hpp>

#include <algorithm>

namespace anogate {
namespace {

using namespace key_rows;
using S = MavlinkSettings;
using D = MavlinkDevice;

constexpr std::uint64_t max_control = 107, max_place = 128, percent = 1000, last_system = 250, last_type = 255, max_cells = 14;
constexpr std::uint64_t slowest = 1200, fastest = 4'000'000;

constexpr Key<S> setting_rows[] = {
    text<&S::control>("control", 0, max_control, "the control socket of the gateway (default: the one that anoctl finds)") |
        as("PATH") | by("--control"),
    words<&S::udp>("udp", 1, max_place, "send to these ground stations, such as 192.168.1.20:14550") | as("HOST:PORT"),
    words<&S::udp_listen>("udp_listen", 1, max_place, "ground stations send to this address first, such as 0.0.0.0:14551") |
        as("ADDR:PORT"),
    words<&S::tcp_listen>("tcp_listen", 1, max_place, "ground stations connect to this address, such as 0.0.0.0:5760") |
        as("ADDR:PORT"),
    words<&S::serial>("serial", 1, max_path, "serial ports of telemetry radios") | as("DEVICE"),
    integer<&S::baud>("baud", slowest, fastest, "the baud rate of the serial ports") | by("--baud"),
    text<&S::signing_file>(
        "signing_file", 1, max_path,
        "a file whose first line is the passphrase for signed packets, as in the ground station; others are refused") |
        as("FILE") | by("--signing-file"),
    choice<&S::autopilot>("autopilot", "generic|px4|ardupilot",
                          "as which autopilot the devices are shown: stations offer actions by it") |
        by("--autopilot"),
};

std::string set_accept(const KeyFacts& key, Value value, D& device) {
    auto& names = std::get<std::vector<std::string>>(value);
    const auto& known = mavlink::stick_input_names;
    for (const std::string& name : names)
        if (std::find(std::begin(known), std::end(known), name) == std::end(known))
            return in_quotes(key.name) + " has " + in_quotes(name) +
                   ", which is not manual_control, rc_override, velocity or attitude" + ano::did_you_mean(name, known);
    device.accept = std::move(names);
    return {};
}

constexpr Key<D> device_rows[] = {
    address<&D::address>("address", first_id, last_id, "the hardware id of the device") | needed,
    text<&D::link>("link", 1, max_name, "only while the device is on this link (default: any)") | as("LINK"),
    integer<&D::system>("system", 1, last_system, "the system id under which stations see it") | needed,
    integer<&D::type>("type", 0, last_type, "the kind of vehicle, as MAV_TYPE: 2 a quadrotor, 13 a hexarotor, 14 an octorotor"),
    integer<&D::cells>("cells", 0, max_cells, "cells of the battery, which share its voltage (default: unknown)"),
    choice<&D::commands>("commands", "named|vendor", "its commands: by the names that it describes, or by the vendor's numbers"),
    Key<D>{{.name = "accept",
            .form = Form::words,
            .help = "how a station may steer it: manual_control, rc_override, velocity, attitude (default: none)",
            .min = 1,
            .max = max_name,
            .stands_for = "INPUT"},
           [](const KeyFacts&, const D& device) { return Value{device.accept}; },
           set_accept},
    decimal<&D::hover_throttle>(
        "hover_throttle", percent, 100 * percent,
        "for velocity and attitude: the throttle at which it hovers, in percent; it counts if the mode changes to "
        "one without height hold"),
};

}    // namespace

Keys<MavlinkSettings> mavlink_keys() noexcept { return setting_rows; }
Keys<MavlinkDevice> mavlink_device_keys() noexcept { return device_rows; }

}    // namespace anogate
