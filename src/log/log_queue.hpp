// The messages that are waiting to be written to the log.
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
    std::string text;      // one line or more
    bool plain = false;    // for standard error, without time and level
};

/// Bounded. If a message does not fit, it and all messages until the next take() are lost, so that there is only one gap.
class LogQueue {
public:
    static constexpr std::size_t room = 64 * 1024;    // bytes; a message fits if fewer are waiting

    struct Batch {
        std::vector<LogMessage> messages;
        std::uint64_t lost = 0;    // lines that were lost after these messages
    };

    void push(spdlog::level::level_enum level, spdlog::log_clock::time_point at, std::string_view text,
              bool plain = false) noexcept;
    /// Counts a line that could not be created for lack of memory.
    void lose() noexcept { ++waiting_.lost; }
    bool empty() const noexcept { return waiting_.messages.empty() && waiting_.lost == 0; }
    /// Takes all waiting messages.
    Batch pop_all() noexcept;

private:
    Batch waiting_;
    std::size_t size_ = 0;
};

}    // namespace anogate
