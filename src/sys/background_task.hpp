// Runs work that may block (on a disk) in a separate thread, and passes the result to the loop.
#pragma once
#include <ano/time.hpp>
#include <sys/descriptor.hpp>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace anogate {

/// One piece of work at a time, each in its own thread. No mutex: the thread owns its data and returns it at the end.
class BackgroundTask {
public:
    explicit BackgroundTask(asio::io_context& io);
    ~BackgroundTask() { stop(); }
    BackgroundTask(const BackgroundTask&) = delete;
    BackgroundTask& operator=(const BackgroundTask&) = delete;

    /// Calls `work` in the thread, where it must not access other data, and then `done` in the loop; `fault` is the message of
    /// the exception that `work` threw, or empty. False: neither is called; why_not() returns the reason.
    bool run(std::function<void()> work, std::function<void(std::string fault)> done);
    /// The reason after run() returned false: "no thread is available".
    std::string_view why_not() const noexcept { return why_not_; }
    bool is_running() const noexcept { return shared_ != nullptr; }
    static constexpr ano::Duration patience_at_the_end = std::chrono::milliseconds{200};
    /// `done` is not called any more. Waits briefly for the thread, at most until `by`; a thread that still hangs is detached.
    void stop() noexcept { stop(ano::Clock::now() + patience_at_the_end); }
    void stop(ano::TimePoint by) noexcept;

private:
    struct Shared;
    void look();

    asio::io_context& io_;
    std::string_view why_not_;
    Descriptor done_event_;    // an eventfd: the thread has finished
    std::shared_ptr<Shared> shared_;
};

}    // namespace anogate
