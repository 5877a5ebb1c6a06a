#include <ano_json/escapes.hpp>
#include <ano_json/text.hpp>
#include <log/log_line.hpp>

#include <spdlog/sinks/sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string>

namespace {

struct Line {
    fmt::string_view format;
    fmt::format_args arguments;
};

}    // namespace

// Formats the line within spdlog, which counts a line that can't be formatted as lost (start_log) and throws no exception.
template <>
struct fmt::formatter<Line> {
    constexpr auto parse(format_parse_context& context) { return context.begin(); }
    template <class Context>
    auto format(const Line& line, Context& context) const {
        fmt::memory_buffer text;
        fmt::vformat_to(fmt::appender{text}, line.format, line.arguments);
        // The text may contain a name from a device, or part of a damaged file.
        const std::string shown = ano::with_escapes(ano::valid_utf8({text.data(), text.size()}));
        return std::copy(shown.begin(), shown.end(), context.out());
    }
};

namespace anogate {
namespace {

spdlog::level::level_enum level_of(LogLevel level) noexcept {
    switch (level) {
    case LogLevel::error: return spdlog::level::err;
    case LogLevel::warning: return spdlog::level::warn;
    case LogLevel::info: break;
    }
    return spdlog::level::info;
}

}    // namespace

void log_line(LogLevel level, fmt::string_view format, fmt::format_args arguments) {
    spdlog::default_logger_raw()->log(level_of(level), "{}", Line{format, arguments});
}

void log_asked(std::string_view text) {
    auto& log = *spdlog::default_logger_raw();
    if (log.level() == spdlog::level::off) return;
    const spdlog::details::log_msg message{log.name(), spdlog::level::info, text};
    for (const auto& sink : log.sinks()) sink->log(message);
}

void set_log_level(const std::string& level) { spdlog::default_logger()->set_level(spdlog::level::from_str(level)); }

}    // namespace anogate
