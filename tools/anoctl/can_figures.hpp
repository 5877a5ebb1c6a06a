// What the kernel knows of a CAN controller beside its interface: netlink tells, sysfs does not.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace anoctl {

/// Empty or 0: not told, as by a virtual interface.
struct CanFigures {
    std::string_view bus;              // "error-active", "error-warning", "error-passive", "bus-off", "stopped", "sleeping"
    std::uint32_t bitrate = 0;         // bit/s
    std::uint32_t data_bitrate = 0;    // bit/s, of the data in CAN FD frames
    bool operator==(const CanFigures&) const = default;
};

/// In a message RTM_NEWLINK, header included.
CanFigures can_figures_in(std::span<const std::uint8_t> message);
/// Asks the kernel; nothing is told of an interface that is not there.
CanFigures can_figures(const std::string& interface);

}    // namespace anoctl
