// Who has a device open, for a status that says what to close.
#pragma once
#include <string>

namespace anogate {

/// "minicom (pid 812)" for a process that has `device` open, as far as /proc lets us read; empty when none is found.
/// Reads the whole of /proc: for a failure, not for the data path.
std::string device_holder(const std::string& device);

}    // namespace anogate
