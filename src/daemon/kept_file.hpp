// A file that is whole or not there, whenever the power goes.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace anogate {

/// Makes its folder as well. Why not, in words; empty: it is kept. An empty `path`: there is no folder for it.
std::string keep_file(const std::string& path, std::span<const std::uint8_t> bytes);
/// Why not, in words; empty: it is not there.
std::string forget_file(const std::string& path);

}    // namespace anogate
