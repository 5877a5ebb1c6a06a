// The folder for data that a program keeps until its next run.
#pragma once
#include <string>

namespace anogate {

/// The first of $STATE_DIRECTORY, which the unit gives (/var/lib/anogate); else $XDG_STATE_HOME/anogate, else
/// ~/.local/state/anogate. Empty: there is none. It need not exist.
std::string state_folder();

}    // namespace anogate
