// The path at which programs find our pseudo-terminal: a symbolic link. Files of other users are never replaced.
#pragma once
#include <sys/expected.hpp>

#include <filesystem>
#include <string>

namespace anogate {

/// Makes the link; replaces only a link left by an earlier run of our own user. Anything else at the path stays, even if it appears at
/// the last moment.
Expected<void> link_to_terminal(const std::string& device, const std::filesystem::path& path);

/// Removes the link if it is still ours and leads to `device`.
void remove_link_to(const std::string& device, const std::filesystem::path& path);

}    // namespace anogate
