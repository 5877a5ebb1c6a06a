// Finds the process that has a device open, for an error text that names it.
#pragma once
#include <string>

namespace anogate {

/// "minicom (pid 812)" for a process that has `device` open, as far as /proc lets us read; empty when none is found.
/// Reads all of /proc: call it after a failure only.
std::string device_holder(const std::string& device);

}    // namespace anogate
