// What must survive a crash of this program: the old values of a calibration that has begun.
#pragma once
#include <string>

namespace anoctl {

/// Keeps `text` as the file `name` in $XDG_STATE_HOME/anogate (else ~/.local/state/anogate); an empty one is removed. Why it can't be
/// kept, in a clause; empty: it is. What an earlier run left there is not overwritten: it says how to write it back.
std::string keep_in_state_folder(const std::string& name, const std::string& text);

/// Whether it is a file of that folder: as long as it is there, no other of its name is kept.
bool is_in_state_folder(const std::string& path);

}    // namespace anoctl
