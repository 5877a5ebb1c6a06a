#include <daemon/log.hpp>
#include <link/own_folder.hpp>

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>

namespace anogate {
namespace {

// Every program that a service or a desktop starts inherits $JOURNAL_STREAM: it names the file that is the journal.
bool stderr_is_journal() {
    const char* stream = std::getenv("JOURNAL_STREAM");
    struct stat info {};
    return stream && ::fstat(STDERR_FILENO, &info) == 0 &&
           std::to_string(info.st_dev) + ":" + std::to_string(info.st_ino) == stream;
}

bool no_color() {
    const char* said = std::getenv("NO_COLOR");
    return said != nullptr && *said != '\0';
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

class JournalFormatter final : public spdlog::formatter {
public:
    void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& into) override {
        const std::string text =
            journal_lines(priority_of(message.level), {message.payload.data(), message.payload.size()});
        into.append(text.data(), text.data() + text.size());
    }
    std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<JournalFormatter>(); }
};

}  // namespace

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

void say(Priority priority, std::string_view lines) {
    if (stderr_is_journal()) std::cerr << journal_lines(priority, lines);
    else std::cerr << lines;
}

void start_log(const LogSettings& settings) {
    constexpr std::size_t files = 3;
    const std::size_t size = settings.rotate == 0 ? std::numeric_limits<std::size_t>::max() : settings.rotate;
    std::shared_ptr<spdlog::logger> log;
    std::string fault;
    std::error_code ec;
    if (std::filesystem::is_fifo(settings.file, ec)) {
        fault = settings.file + " is a pipe, and one that nobody reads would hold up everything";
    } else if (!settings.file.empty()) {
        fault = make_folder_of(settings.file);    // or the sink would make any
    }
    if (!settings.file.empty() && fault.empty()) {
        try {
            log = spdlog::rotating_logger_st("anogated", settings.file, size, files);
        } catch (const spdlog::spdlog_ex& e) {
            fault = e.what();
        }
    }
    const bool journal = !log && stderr_is_journal();
    if (!log) log = spdlog::stderr_color_st("anogated", no_color() ? spdlog::color_mode::never : spdlog::color_mode::automatic);
    if (journal) log->set_formatter(std::make_unique<JournalFormatter>());
    else log->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
    log->set_level(spdlog::level::from_str(settings.level));
    log->flush_on(spdlog::level::info);
    spdlog::set_default_logger(std::move(log));
    if (!fault.empty()) spdlog::warn("the log goes to standard error: {}", fault);
}

}  // namespace anogate
