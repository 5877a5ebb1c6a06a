// Properties of a CAN controller that the kernel provides by netlink, but not in sysfs.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace anoctl {

/// Empty or 0: not known, for example for a virtual interface.
struct CanFigures {
    std::string_view bus;              // "error-active", "error-warning", "error-passive", "bus-off", "stopped", "sleeping"
    std::uint32_t bitrate = 0;         // bit/s
    std::uint32_t data_bitrate = 0;    // bit/s, for the data phase of CAN FD frames
    bool operator==(const CanFigures&) const = default;
};

/// From an RTM_NEWLINK message, including its header.
CanFigures can_figures_in(std::span<const std::uint8_t> message);
/// Requests the figures from the kernel. All are empty or 0 if the interface does not exist.
CanFigures can_figures(const std::string& interface);

}    // namespace anoctl
