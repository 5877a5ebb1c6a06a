// A small file as text.
#pragma once
#include <cstddef>
#include <string>
#include <system_error>

namespace anogate {

/// Bytes. Configurations are far smaller; a larger file is probably a device or a log.
inline constexpr std::size_t max_config_size = 1 << 20;

/// The whole file; `error` is set if it is not readable: file_too_large if it has more than `max_bytes`, operation_not_supported if
/// it has no end, such as a pipe or /proc/kmsg. Never blocks.
std::string read_file(const std::string& path, std::size_t max_bytes, std::error_code& error);

}    // namespace anogate
