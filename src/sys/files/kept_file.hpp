// Files that are complete or do not exist, even after a loss of power.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace anogate {

/// Writes the file, and makes its folder. Returns empty, or the reason why not. An empty `path` means that there is no folder for it.
std::string keep_file(const std::string& path, std::span<const std::uint8_t> bytes);
/// The content, at most `max_bytes`; std::nullopt when the file does not exist, or, with a `fault` in words, when it can't be read. A pipe
/// or a device at this path is not read: that might block for ever. For the start of the program: it removes what a keep_file() that was cut
/// off has left.
std::optional<std::string> read_kept_file(const std::string& path, std::size_t max_bytes, std::string& fault);
/// Removes the file. Returns empty when it no longer exists, or the reason why not.
std::string forget_file(const std::string& path);

}    // namespace anogate
