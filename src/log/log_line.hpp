// Logs lines of text, formatted by fmt. Separate from log.hpp and without spdlog, because two dozen sources need only this and
// would otherwise compile spdlog as well.
#pragma once
#include <fmt/core.h>

#include <string>
#include <string_view>

namespace anogate {

enum class LogLevel { info, warning, error };

/// Does not format a message below the level of the log.
void log_line(LogLevel level, fmt::string_view format, fmt::format_args arguments);

/// Logs text that a user has just requested, at every level except off.
void log_asked(std::string_view text);

/// `level`: trace, debug, info, warn, error or off. Messages below it are not logged.
void set_log_level(const std::string& level);

template <class... Arguments>
void log_info(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log_line(LogLevel::info, format, fmt::make_format_args(arguments...));
}
template <class... Arguments>
void log_warning(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log_line(LogLevel::warning, format, fmt::make_format_args(arguments...));
}
template <class... Arguments>
void log_error(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    log_line(LogLevel::error, format, fmt::make_format_args(arguments...));
}

}    // namespace anogate
