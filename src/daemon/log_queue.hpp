// What waits to be written into the log.
#pragma once
#include <spdlog/common.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct LogMessage {
    spdlog::level::level_enum level = spdlog::level::info;
    spdlog::log_clock::time_point at;
    std::string text;      // of one line or more
    bool plain = false;    // for standard error, as it is
};

/// Bounded. What does not fit is lost, and so is what comes after it until all that waits is taken: then the gap is in one place.
class LogQueue {
public:
    static constexpr std::size_t room = 64 * 1024;    // bytes; a message that begins below it fits, however long it is

    struct Batch {
        std::vector<LogMessage> messages;
        std::uint64_t lost = 0;    // lines, after those messages
    };

    void push(spdlog::level::level_enum level, spdlog::log_clock::time_point at, std::string_view text,
              bool plain = false) noexcept;
    /// A line that could not even be made.
    void lose() noexcept { ++waiting_.lost; }
    bool empty() const noexcept { return waiting_.messages.empty() && waiting_.lost == 0; }
    /// All that waits, and there is room again.
    Batch take() noexcept;

private:
    Batch waiting_;
    std::size_t size_ = 0;
};

}    // namespace anogate
