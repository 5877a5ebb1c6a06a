// Lists the serial ports and CAN interfaces, for people and for programs.
#pragma once
#include "port_list.hpp"

#include <filesystem>
#include <iosfwd>

namespace anoctl {

/// In lines of at most 80 columns, or one JSON object for each port. `root`: as in serial_ports(); unless it is "/", the kernel is not
/// asked for the figures of CAN controllers.
void write_ports(const std::filesystem::path& root, const anogate::DeviceUser& asker, bool json, std::ostream& out);

}    // namespace anoctl
