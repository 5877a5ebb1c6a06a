// Keeps the old values of a running calibration, so that they survive a crash of this program, and what the user stated of a device.
#pragma once
#include <map>
#include <string>
#include <string_view>

namespace anoctl {

/// What becomes of the file of a calibration that is there already: one of an earlier run stays.
enum class Earlier : bool { stays, replaced };

/// Keeps `text` as the file `name` in $XDG_STATE_HOME/anogate (else ~/.local/state/anogate); an empty text removes the file. Returns empty,
/// or a clause with the reason why not. Of a file that stays the reason says how to restore its values.
std::string keep_in_state_folder(const std::string& name, const std::string& text, Earlier earlier = Earlier::stays);

/// The files of that folder whose names are `wanted`, by their names. One that can't be read is left out.
std::map<std::string, std::string> texts_in_state_folder(bool (*wanted)(std::string_view name));

std::string path_in_state_folder(const std::string& name);

/// A text whose loss costs time only, in $XDG_CACHE_HOME/anogate (else ~/.cache/anogate). Empty: there is none.
std::string cached_text(const std::string& name);
void cache_text(const std::string& name, const std::string& text);

/// Whether `path` is a file in that folder: while it exists, no other one of its name is kept.
bool is_in_state_folder(const std::string& path);

}    // namespace anoctl
