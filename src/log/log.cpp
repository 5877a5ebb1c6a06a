#include <log/log.hpp>
#include <log/log_writer.hpp>
#include <sys/files/own_folder.hpp>

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>

namespace anogate {
namespace {

// Programs started by a service or a desktop inherit $JOURNAL_STREAM, so its device and inode must be those of standard error.
bool stderr_is_journal() {
    const char* stream = std::getenv("JOURNAL_STREAM");
    struct stat info {};
    return stream && ::fstat(STDERR_FILENO, &info) == 0 &&
           std::to_string(info.st_dev) + ":" + std::to_string(info.st_ino) == stream;
}

bool no_color() {
    const char* value = std::getenv("NO_COLOR");
    return value != nullptr && *value != '\0';
}

Priority priority_of(spdlog::level::level_enum level) {
    switch (level) {
    case spdlog::level::critical:
    case spdlog::level::err: return Priority::error;
    case spdlog::level::warn: return Priority::warning;
    case spdlog::level::info: return Priority::info;
    default: return Priority::debug;
    }
}

// The sink of the default logger of spdlog.
std::shared_ptr<LogWriter> writer;

class JournalFormatter final : public spdlog::formatter {
public:
    void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& into) override {
        const std::string text = journal_lines(priority_of(message.level), {message.payload.data(), message.payload.size()});
        into.append(text.data(), text.data() + text.size());
    }
    std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<JournalFormatter>(); }
};

// Opens the file, if one is configured and can be opened. May block on a disk that hangs.
std::shared_ptr<spdlog::logger> open_file(const LogSettings& settings, std::string& fault) {
    constexpr std::size_t files = 3;
    constexpr std::uint64_t max_size = std::numeric_limits<std::size_t>::max();
    const auto size = static_cast<std::size_t>(settings.rotate == 0 ? max_size : std::min(settings.rotate, max_size));
    std::error_code ec;
    if (settings.file.empty()) return {};
    if (std::filesystem::is_fifo(settings.file, ec)) fault = settings.file + " is a pipe, not a file";
    else if (auto folder = make_folder_of(settings.file); !folder)
        fault = std::move(folder.error());    // without this check, the sink would create all missing folders
    if (!fault.empty()) return {};
    try {
        return std::make_shared<spdlog::logger>(
            "anogated", std::make_shared<spdlog::sinks::rotating_file_sink_st>(settings.file, size, files));
    } catch (const spdlog::spdlog_ex& e) {
        fault = e.what();
    }
    return {};
}

std::shared_ptr<spdlog::logger> open_log(const LogSettings& settings) {
    std::string fault;
    auto log = open_file(settings, fault);
    const bool journal = !log && stderr_is_journal();
    const auto color = no_color() ? spdlog::color_mode::never : spdlog::color_mode::automatic;
    if (!log) log = std::make_shared<spdlog::logger>("anogated", std::make_shared<spdlog::sinks::stderr_color_sink_st>(color));
    if (journal) log->set_formatter(std::make_unique<JournalFormatter>());
    else log->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
    log->set_level(spdlog::level::trace);    // messages are already filtered
    if (!fault.empty()) log->warn("logging to standard error: {}", fault);
    return log;
}

}    // namespace

std::string journal_lines(Priority priority, std::string_view text) {
    const std::string prefix = "<" + std::to_string(static_cast<int>(priority)) + ">";
    std::string lines;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        if (end > 0) lines += prefix + std::string{text.substr(0, end)} + "\n";
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return lines;
}

void print_lines(Priority priority, std::string_view lines) {
    const std::string text = stderr_is_journal() ? journal_lines(priority, lines) : std::string{lines};
    if (writer) writer->print_lines(text);
    else std::cerr << text;
}

void start_log(const LogSettings& settings) {
    writer = std::make_shared<LogWriter>([settings] { return open_log(settings); });
    const auto log = std::make_shared<spdlog::logger>("anogated", writer);
    log->set_level(spdlog::level::from_str(settings.level));
    log->set_error_handler([](const std::string&) { writer->lose(); });    // spdlog's handler writes to standard error
    spdlog::set_default_logger(log);
}

bool end_log() { return !writer || writer->finish(); }

}    // namespace anogate
