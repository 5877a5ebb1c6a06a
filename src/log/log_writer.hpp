// Writes the log in a thread, so that logging never blocks on a stopped terminal, a pipe that is not read, or a disk that hangs.
#pragma once
#include <log/log_queue.hpp>

#include <spdlog/logger.h>
#include <spdlog/sinks/sink.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string_view>
#include <thread>

namespace anogate {

/// Queues messages; a thread opens the log and writes them in order. The number of lost messages is logged at the position where
/// they are missing. O_NONBLOCK is no alternative: it affects all programs that share the descriptor, and has no effect on files.
class LogWriter final : public spdlog::sinks::sink {
public:
    static constexpr std::chrono::milliseconds patience{200};    // of finish(), and between two attempts to open the log

    /// Called in the thread, where it may block. Called again if it throws std::bad_alloc; it must not throw any other exception.
    using Open = std::function<std::shared_ptr<spdlog::logger>()>;

    /// `finish_patience`: how long finish() waits. Throws std::system_error if a thread can't be started.
    explicit LogWriter(Open open, std::chrono::milliseconds finish_patience = patience);
    ~LogWriter() override { finish(); }
    LogWriter(const LogWriter&) = delete;
    LogWriter& operator=(const LogWriter&) = delete;

    /// Writes `text` to standard error, after the earlier messages.
    void print_lines(std::string_view text) noexcept;
    /// Counts a line that could not be created.
    void lose() noexcept;
    /// Waits until all messages are written, at most `finish_patience`. False: the thread stays blocked and holds locks, perhaps that of
    /// stderr, so that only _exit() reliably ends the program.
    bool finish();

    void log(const spdlog::details::log_msg& message) override;
    void flush() override {}
    void set_pattern(const std::string&) override {}
    void set_formatter(std::unique_ptr<spdlog::formatter>) override {}

private:
    struct Shared {    // shared with the thread, which may outlive this object
        std::mutex mutex;
        std::condition_variable changed;
        LogQueue queue;
        bool ending = false;
        bool ended = false;
    };
    static std::shared_ptr<spdlog::logger> opened(Shared& shared, const Open& open);
    static void run(Shared& shared, const Open& open);
    template <class Change>
    void change(Change change) noexcept;

    std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
    std::chrono::milliseconds finish_patience_;
    std::thread thread_;
    bool finished_ = false;
};

}    // namespace anogate
