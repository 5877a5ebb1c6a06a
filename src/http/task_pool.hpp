// Runs disk operations in a few threads, so that the loop never waits for a disk that hangs.
#pragma once
#include <http/response.hpp>
#include <sys/background_task.hpp>

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <string>

namespace anogate {

/// Each operation has a thread of its own, which ends with it. At most four run at once; further ones wait.
class TaskPool {
public:
    explicit TaskPool(asio::io_context& io);
    TaskPool(const TaskPool&) = delete;
    TaskPool& operator=(const TaskPool&) = delete;

    /// Must be held until `done` is called. If it is released earlier, `done` is not called, and work that has not begun is
    /// dropped.
    using Ticket = std::shared_ptr<void>;
    /// As BackgroundTask::run(). `done` is never called from within this call.
    Ticket run(std::function<void()> work, std::function<void(std::string fault)> done);
    /// The same without a ticket: the work is always done, unless stop() is called first.
    void run_detached(std::function<void()> work, std::function<void(std::string fault)> done);
    /// Starts no further work and makes no further calls of `done`.
    void stop();

private:
    struct Task {
        std::function<void()> work;
        std::function<void(std::string)> done;
    };
    void begin();
    void begin(BackgroundTask& worker, const std::shared_ptr<Task>& task);
    void complete(const std::shared_ptr<Task>& task, std::string fault);

    asio::io_context& io_;
    std::array<BackgroundTask, 4> workers_;
    std::deque<std::weak_ptr<Task>> waiting_;
    std::set<Ticket> unheld_;
    bool stopped_ = false;
};

/// The response that `work` makes in a thread. `work` must not touch data that other threads use.
http::Response answer_from(TaskPool& disk, std::function<http::Response()> work);

}    // namespace anogate
