// Folders that anogate creates if they are missing. Any other missing folder is a typing error, or its disk is not mounted yet.
#pragma once
#include <sys/expected.hpp>

#include <filesystem>
#include <string>

namespace anogate {

/// For root and the service: RuntimeDirectory= of the unit.
inline constexpr char runtime_folder[] = "/run/anogate";

/// Whether `folder` is one of /run/anogate, /run/anogate-NAME (of anogated@NAME.service), /var/log/anogate, `runtime_dir`
/// ($XDG_RUNTIME_DIR; empty: none) and anogate in it, or is below one of them.
bool is_own_folder(const std::filesystem::path& folder, const std::string& runtime_dir);

/// The folder of `path`; "." for a name without a folder.
std::filesystem::path folder_of(const std::filesystem::path& path);

/// Creates that folder if it is missing and is_own_folder(). An error if it does not exist afterwards.
Expected<void> make_folder_of(const std::filesystem::path& path);

/// The error that make_folder_of() would return; changes nothing.
Expected<void> check_folder_of(const std::filesystem::path& path);

/// Whether `path` exists and is not a link to a pseudo-terminal, which an earlier run may have left.
bool is_taken(const std::filesystem::path& path);

}    // namespace anogate
