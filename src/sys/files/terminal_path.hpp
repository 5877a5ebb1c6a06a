// The path of our pseudo-terminal for other programs: a symbolic link. Files of other users are never replaced.
#pragma once
#include <sys/expected.hpp>

#include <filesystem>
#include <string>

namespace anogate {

/// Creates the symbolic link; replaces only one left by an earlier run of our own user. Any other file at the path is kept, even
/// if it appears during the call.
Expected<void> link_to_terminal(const std::string& device, const std::filesystem::path& path);

/// Removes the symbolic link if it is still ours and leads to `device`.
void remove_link_to(const std::string& device, const std::filesystem::path& path);

}    // namespace anogate
