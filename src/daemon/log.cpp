#include <daemon/log.hpp>

#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdlib>
#include <filesystem>
#include <limits>

namespace anogate {

void start_log(const LogSettings& settings) {
    constexpr std::size_t files = 3;
    const std::size_t size = settings.rotate == 0 ? std::numeric_limits<std::size_t>::max() : settings.rotate;
    std::shared_ptr<spdlog::logger> log;
    std::string fault;
    std::error_code ec;
    if (std::filesystem::is_fifo(settings.file, ec)) {
        fault = settings.file + " is a pipe, and one that nobody reads would hold up everything";
    } else if (!settings.file.empty()) {
        try {
            log = spdlog::rotating_logger_st("anogated", settings.file, size, files);
        } catch (const spdlog::spdlog_ex& e) {
            fault = e.what();
        }
    }
    if (!log) log = spdlog::stderr_color_st("anogated");
    const bool journal = settings.file.empty() && std::getenv("JOURNAL_STREAM");
    log->set_pattern(journal ? "%l: %v" : "%Y-%m-%d %H:%M:%S %^%l%$ %v");
    log->set_level(spdlog::level::from_str(settings.level));
    log->flush_on(spdlog::level::info);
    spdlog::set_default_logger(std::move(log));
    if (!fault.empty()) spdlog::warn("the log goes to standard error: {}", fault);
}

}  // namespace anogate
