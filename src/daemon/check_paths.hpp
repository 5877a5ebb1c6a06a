// Checks whether the paths of a configuration exist on this machine and are of the right kind.
#pragma once
#include <config/config.hpp>

namespace anogate {

/// Adds a warning for every pty and log file whose folder is missing or whose path is in use, for every serial device that is a
/// folder or an ordinary file, or whose name in /dev/serial/by-id may lead to another adapter, and for every recording to replay
/// and every network interface of an address that is missing. These are not errors, because the configuration may be for another machine, or the
/// disk may be mounted later.
void warn_of_paths(Draft& draft);

}    // namespace anogate
