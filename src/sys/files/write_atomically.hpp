// Files that are complete or do not exist, even after a loss of power.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace anogate {

/// Writes the file, and creates its folder. Returns empty, or the reason for the failure. An empty `path` means that there is no
/// folder.
std::string write_atomically(const std::string& path, std::span<const std::uint8_t> bytes);
/// The content, at most `max_bytes`; std::nullopt: the file does not exist, or it is not readable; then `fault` is the reason. A
/// pipe or a device at this path is not read, because that might block for ever. For the start of the program: also removes the
/// remains of an interrupted write_atomically().
std::optional<std::string> read_kept_file(const std::string& path, std::size_t max_bytes, std::string& fault);
/// Removes the file. Returns empty if it no longer exists, or the reason for the failure.
std::string forget_file(const std::string& path);

}    // namespace anogate
