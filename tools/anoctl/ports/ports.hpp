// Lists the serial ports and CAN interfaces, for people and for programs.
#pragma once
#include "port_list.hpp"

#include <filesystem>
#include <iosfwd>

namespace anoctl {

/// Prints lines of at most 80 columns, or one JSON object for each port. `root`: as for serial_ports(). If it is not "/", the
/// figures of CAN controllers are not requested from the kernel.
void write_ports(const std::filesystem::path& root, const anogate::DeviceUser& asker, bool json, std::ostream& out);

}    // namespace anoctl
