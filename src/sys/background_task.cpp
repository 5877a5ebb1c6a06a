#include <sys/asio.hpp>
#include <sys/background_task.hpp>
#include <sys/thread_signals.hpp>

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <system_error>
#include <utility>

namespace anogate {

/// Shared with the thread, which may outlive the BackgroundTask.
struct BackgroundTask::Shared {
    std::function<void()> work;
    std::function<void(std::string)> done;    // used by the loop only
    std::string fault;
    UniqueFd event;
    std::atomic<bool> is_done{false};
    bool is_stopped = false;    // used by the loop only
};

BackgroundTask::BackgroundTask(asio::io_context& io) : io_{io}, done_event_{io} {}

bool BackgroundTask::run(std::function<void()> work, std::function<void(std::string)> done) {
    auto shared = std::make_shared<Shared>();
    shared->event = UniqueFd{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
    UniqueFd event{shared->event ? ::fcntl(shared->event.get(), F_DUPFD_CLOEXEC, 0) : -1};
    why_not_ = "no file descriptor is available (ulimit -n)";
    if (!event) return false;
    why_not_ = "no thread is available";
    shared->work = std::move(work);
    shared->done = std::move(done);
    try {
        begin_thread([shared] {
            try {
                shared->work();
            } catch (const std::exception& e) {
                shared->fault = e.what();
            }
            shared->is_done.store(true, std::memory_order_release);
            ::eventfd_write(shared->event.get(), 1);
        }).detach();
    } catch (const std::system_error&) {
        return false;
    }
    shared_ = std::move(shared);
    done_event_.open(std::move(event));
    done_event_.read_with([this] { look(); });
    return true;
}

// Moves `done` before the call, because `done` may call run() again.
void BackgroundTask::look() {
    if (!shared_->is_done.load(std::memory_order_acquire)) return;
    done_event_.close();
    asio::post(io_, [this, shared = shared_] {
        if (shared->is_stopped) return;
        shared_.reset();
        const auto done = std::move(shared->done);
        done(std::move(shared->fault));
    });
}

void BackgroundTask::stop(ano::TimePoint by) noexcept {
    done_event_.close();
    const auto shared = std::exchange(shared_, nullptr);
    if (!shared) return;
    shared->is_stopped = true;
    shared->done = nullptr;
    const ano::TimePoint now = ano::Clock::now();
    if (by <= now) return;
    pollfd event{shared->event.get(), POLLIN, 0};
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(by - now).count();
    ::poll(&event, 1, static_cast<int>(left));
}

}    // namespace anogate
