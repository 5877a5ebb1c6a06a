// The folder for data that a program stores for its next run.
#pragma once
#include <string>

namespace anogate {

/// The first folder in $STATE_DIRECTORY, which the unit sets (/var/lib/anogate); else $XDG_STATE_HOME/anogate, else
/// ~/.local/state/anogate. Empty: none. It need not exist.
std::string state_folder();

}    // namespace anogate
