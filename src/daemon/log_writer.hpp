// Who logs never waits: not for a terminal that was stopped, a pipe that nobody reads, a disk that hangs.
#pragma once
#include <daemon/log_queue.hpp>

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

/// Takes messages, and has a thread of its own that opens the log and writes them in their order. What it could not take is told in
/// the log at that place. O_NONBLOCK would be no way: it changes the descriptor for all who share it, and nothing on a disk.
class LogWriter final : public spdlog::sinks::sink {
public:
    static constexpr std::chrono::milliseconds patience{200};    // at the end

    /// Called in the thread, and may wait there. It does not throw.
    using Open = std::function<std::shared_ptr<spdlog::logger>()>;

    /// Throws std::system_error when there is no thread to be had.
    explicit LogWriter(Open open);
    ~LogWriter() override { finish(); }
    LogWriter(const LogWriter&) = delete;
    LogWriter& operator=(const LogWriter&) = delete;

    /// Writes it to standard error, in its turn.
    void say(std::string_view text) noexcept;
    /// A line that could not even be made.
    void lose() noexcept;
    /// Waits until all is written, for `patience` at most. False: it is not, and the thread waits on with whatever it holds, the lock of
    /// stderr among it: only _exit() is sure to end the program.
    bool finish();

    void log(const spdlog::details::log_msg& message) override;
    void flush() override {}
    void set_pattern(const std::string&) override {}
    void set_formatter(std::unique_ptr<spdlog::formatter>) override {}

private:
    struct Shared {    // with the thread, which may be left behind
        std::mutex mutex;
        std::condition_variable changed;
        LogQueue queue;
        bool ending = false;
        bool ended = false;
    };
    static void run(Shared& shared, const Open& open);
    template <class Change>
    void change(Change change) noexcept;

    std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
    std::thread thread_;
    bool finished_ = false;
};

}    // namespace anogate
