// Finds the process that has a device open, to name it to the user.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

/// A process, by its number and its short name.
struct DeviceHolder {
    int pid = 0;
    std::string program;

    std::string text() const { return program + " (pid " + std::to_string(pid) + ")"; }    // "minicom (pid 812)"
    /// Whether the process still runs.
    bool is_there() const;
};

enum class OtherSide : std::uint8_t { counts, does_not_count };

/// A process other than this one and init that has `device` open, as far as /proc lets us read; std::nullopt: none is found. Reads all of
/// /proc: call it when a device is opened, or after a failure.
/// `other_side`: whether a process counts that also has the master of the pseudo-terminal `device`, as socat may: it is what the device
/// is connected to, and takes nothing away.
std::optional<DeviceHolder> device_holder(const std::string& device, OtherSide other_side = OtherSide::counts);

}    // namespace anogate
