// What there is to connect to, for people and for programs.
#pragma once
#include "port_list.hpp"

#include <filesystem>
#include <iosfwd>

namespace anoctl {

/// In lines of at most 80 columns, or one JSON object a port. `root`: as of serial_ports(); of another than "/" the kernel is not
/// asked what it knows of CAN controllers.
void write_ports(const std::filesystem::path& root, const anogate::DeviceUser& asker, bool json, std::ostream& out);

}    // namespace anoctl
