// Paths of a configuration that this machine has nothing for, or something else.
#pragma once
#include <config/config.hpp>

namespace anogate {

/// Adds a warning for every pty and log file whose folder is missing or whose place is taken, and for every serial device
/// that is a folder or an ordinary file. No faults: it may be another machine's, or the disk comes later.
void warn_of_paths(Draft& draft);

}    // namespace anogate
