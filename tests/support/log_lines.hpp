// Collects log lines.
#pragma once
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace support {

/// Replaces the log as long as this object exists.
class LogLines {
public:
    LogLines() {
        const auto log = std::make_shared<spdlog::logger>("lines", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_));
        log->set_pattern("%v");
        log->flush_on(spdlog::level::trace);
        spdlog::set_default_logger(log);
    }
    ~LogLines() { spdlog::set_default_logger(before_); }
    LogLines(const LogLines&) = delete;
    LogLines& operator=(const LogLines&) = delete;

    /// The lines since the last call.
    std::vector<std::string> pop_all() {
        std::istringstream said{std::exchange(text_, std::ostringstream{}).str()};
        std::vector<std::string> lines;
        for (std::string line; std::getline(said, line);) lines.push_back(line);
        return lines;
    }

private:
    std::ostringstream text_;
    std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
};

}    // namespace support
