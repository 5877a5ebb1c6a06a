// Stores the old values of a running calibration, so that they survive a crash of this program, and facts that the user stated
// about a device.
#pragma once
#include <map>
#include <string>
#include <string_view>

namespace anoctl {

/// Whether an existing file of a calibration is kept or replaced. The file of an earlier run must be kept.
enum class Earlier : bool { stays, replaced };

/// Saves `text` as the file `name` in $XDG_STATE_HOME/anogate (else ~/.local/state/anogate); an empty text removes the file.
/// Returns empty, or a clause with the error. If an existing file was kept, the error says how to restore its values.
std::string keep_in_state_folder(const std::string& name, const std::string& text, Earlier earlier = Earlier::stays);

/// The content of the files in that folder for which `wanted` returns true, by name. Unreadable files are omitted.
std::map<std::string, std::string> texts_in_state_folder(bool (*wanted)(std::string_view name));

std::string path_in_state_folder(const std::string& name);

/// A text from $XDG_CACHE_HOME/anogate (else ~/.cache/anogate), which can be read from the device again. Empty: none.
std::string cached_text(const std::string& name);
void cache_text(const std::string& name, const std::string& text);

/// Whether `path` is in the state folder: while such a file of a calibration exists, keep_in_state_folder() does not replace it.
bool is_in_state_folder(const std::string& path);

}    // namespace anoctl
