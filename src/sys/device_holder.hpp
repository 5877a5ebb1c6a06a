// Finds the process that has a device open, for messages to the user.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

/// A process: its number and short name.
struct DeviceHolder {
    int pid = 0;
    std::string program;

    std::string text() const { return program + " (pid " + std::to_string(pid) + ")"; }    // "minicom (pid 812)"
    /// Whether the process is still running.
    bool is_there() const;
};

enum class OtherSide : std::uint8_t { counts, does_not_count };

/// A process other than this one and init that has `device` open, as far as /proc is readable; std::nullopt: none found. Reads
/// all of /proc: only for use when a device is opened, or after a failure. `other_side`: whether to count a process that also has
/// the master of the pseudo-terminal `device`, as socat may. Such a process is the other end of the device, and does not read its
/// data.
std::optional<DeviceHolder> device_holder(const std::string& device, OtherSide other_side = OtherSide::counts);

}    // namespace anogate
