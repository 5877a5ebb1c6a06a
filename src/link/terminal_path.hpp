// The path at which a program finds our pseudo-terminal: a link to it, made where another user's things are left alone.
#pragma once
#include <link/expected.hpp>

#include <filesystem>
#include <string>

namespace anogate {

/// Makes the link, in place of one that an earlier run of our own user left. Whatever else is there, or comes to be there at the
/// last moment, stays.
Expected<void> link_to_terminal(const std::string& device, const std::filesystem::path& path);

/// Removes it when it still is ours and leads to `device`.
void remove_link_to(const std::string& device, const std::filesystem::path& path);

}    // namespace anogate
