// Reads and prints the configuration of anogate-mavlink, by the rules of that of anogated: comments are allowed, unknown keys are errors.
#pragma once
#include <config/config_error.hpp>
#include <config/keys.hpp>
#include <mavlink/settings.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// Without "devices" and "log".
Keys<MavlinkSettings> mavlink_keys() noexcept;
/// Without "funs", "velocity_modes", "attitude_modes" and "aux", lists of numbers and objects.
Keys<MavlinkDevice> mavlink_device_keys() noexcept;

struct MavlinkList {
    std::string_view name, placeholder, help;
};
/// Those.
std::span<const MavlinkList> mavlink_device_lists() noexcept;

/// Adds the configuration in `json` to `settings`. `file` is the prefix of the places of errors, "" for none.
void read_mavlink_config(std::string_view json, const std::string& file, MavlinkSettings& settings, ConfigErrors& errors);
/// Errors that concern several keys; after all of them are set.
void check_mavlink_settings(const MavlinkSettings& settings, ConfigErrors& errors);
/// An equivalent configuration file.
std::string print_mavlink_config(const MavlinkSettings& settings);
/// The JSON Schema (draft 7).
std::string mavlink_config_schema();

/// "0xDC:1", the form of --device; std::nullopt: not valid.
std::optional<MavlinkDevice> parse_mavlink_device(std::string_view text);

}    // namespace anogate
