// What the daemon logs: lines of text, in the format of fmt. Apart from log.hpp, and without spdlog in it, since two dozen sources need
// no more than this and would each compile spdlog for it.
#pragma once
#include <fmt/core.h>

#include <string>

namespace anogate {

enum class LogLevel { info, warning, error };

/// Nothing is formatted that is below the level of the log.
void log_line(LogLevel level, fmt::string_view format, fmt::format_args arguments);

/// trace, debug, info, warn, error or off: what is below is not logged.
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
