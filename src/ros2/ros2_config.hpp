// Reads and prints the configuration of anogate-ros2, by the rules of that of anogated: comments are allowed, unknown keys are errors.
#pragma once
#include <config/config_error.hpp>
#include <config/keys.hpp>
#include <ros2/settings.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// Without "velocity_modes", a list of numbers.
Keys<Ros2Device> ros2_device_keys() noexcept;
inline constexpr std::string_view velocity_modes_help =
    "the flight modes (0x06) in which it follows velocities (default: [2], position hold)";

/// Without "qos" and "variances", objects by the name of a topic or measurement, "devices" and "log".
Keys<Ros2Settings> ros2_keys() noexcept;

struct VarianceKey {
    std::string_view name, help;
    double Variances::*field;
};
std::span<const VarianceKey> variance_keys() noexcept;

/// Adds the configuration in `json` to `settings`. `file` is the prefix of the places of errors, "" for none.
void read_ros2_config(std::string_view json, const std::string& file, Ros2Settings& settings, ConfigErrors& errors);

/// An equivalent configuration file.
std::string print_ros2_config(const Ros2Settings& settings);

/// The JSON Schema (draft 7).
std::string ros2_config_schema();

}    // namespace anogate
