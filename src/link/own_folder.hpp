// Folders that anogate makes when they are missing. A path elsewhere that has none was mistyped, or its disk is not there yet.
#pragma once
#include <link/expected.hpp>

#include <filesystem>
#include <string>

namespace anogate {

/// Of root and of the service: RuntimeDirectory= of the unit.
inline constexpr char runtime_folder[] = "/run/anogate";

/// /run/anogate, /run/anogate-NAME (of anogated@NAME.service), /var/log/anogate, `runtime_dir` ($XDG_RUNTIME_DIR; empty: none) with
/// its anogate, and what is below those.
bool is_own_folder(const std::filesystem::path& folder, const std::string& runtime_dir);

/// The folder that `path` is to be made in; "." for a name alone.
std::filesystem::path folder_of(const std::filesystem::path& path);

/// Makes that folder when it is missing and our own. Afterwards it is there, or what is wrong with it is said.
Expected<void> make_folder_of(const std::filesystem::path& path);

/// What is wrong where that would make none and `path` has no folder; looks only.
Expected<void> check_folder_of(const std::filesystem::path& path);

/// Something is at `path`, and no link to a pseudo-terminal, which an earlier run may have left.
bool is_taken(const std::filesystem::path& path);

}    // namespace anogate
