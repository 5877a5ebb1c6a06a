// A file that is whole or not there, whenever the power goes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace anogate {

/// Makes its folder as well. Why not, in words; empty: it is kept. An empty `path`: there is no folder for it.
std::string keep_file(const std::string& path, std::span<const std::uint8_t> bytes);
/// What is kept there, at most `max_bytes`; nothing when it is not there, or, with a `fault` in words, when it can't be read. A pipe or
/// a device in its place is not read: that might wait for ever.
std::optional<std::string> read_kept_file(const std::string& path, std::size_t max_bytes, std::string& fault);
/// Why not, in words; empty: it is not there.
std::string forget_file(const std::string& path);

}    // namespace anogate
