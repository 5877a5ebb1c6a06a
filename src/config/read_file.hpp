// A small file as text.
#pragma once
#include <cstddef>
#include <string>
#include <system_error>

namespace anogate {

/// No configuration is near it; a device or a log may be.
inline constexpr std::size_t max_config_size = 1 << 20;

/// The whole file; `error` is set when it can't be read, file_too_large when it has more than `most` bytes.
std::string read_file(const std::string& path, std::size_t most, std::error_code& error);

}    // namespace anogate
