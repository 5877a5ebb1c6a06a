// Finds texts that can't be the name of a device.
#pragma once
#include <string>

namespace anogate {

/// Why `device` can't be a serial port, with a suggestion; empty: it can. Only the text is checked, because an absent port is no
/// error: the link waits for it.
std::string fault_of_device(const std::string& device);

/// The same for a CAN interface.
std::string fault_of_interface(const std::string& interface);

}    // namespace anogate
