// What a person wrote where a device is named, and which can't be one.
#pragma once
#include <string>

namespace anogate {

/// Why no serial port is called `device`, with what was meant; empty: one may be. Looks at the text only: a port that is
/// absent is waited for.
std::string fault_of_device(const std::string& device);

/// The same for a CAN interface.
std::string fault_of_interface(const std::string& interface);

}    // namespace anogate
