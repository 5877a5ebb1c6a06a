#include <http/task_pool.hpp>
#include <sys/asio.hpp>

#include <utility>

namespace anogate {

TaskPool::TaskPool(asio::io_context& io)
    : io_{io}, workers_{BackgroundTask{io}, BackgroundTask{io}, BackgroundTask{io}, BackgroundTask{io}} {}

TaskPool::Ticket TaskPool::run(std::function<void()> work, std::function<void(std::string)> done) {
    auto task = std::make_shared<Task>(Task{std::move(work), std::move(done)});
    waiting_.push_back(task);
    begin();
    return task;
}

void TaskPool::run_detached(std::function<void()> work, std::function<void(std::string)> done) {
    unheld_.insert(run(std::move(work), std::move(done)));
}

void TaskPool::begin() {
    for (BackgroundTask& worker : workers_) {
        while (!stopped_ && !worker.is_running() && !waiting_.empty()) {
            const auto task = waiting_.front().lock();
            waiting_.pop_front();
            if (task) begin(worker, task);
        }
    }
}

void TaskPool::begin(BackgroundTask& worker, const std::shared_ptr<Task>& task) {
    const auto on_done = [this, weak = std::weak_ptr{task}](std::string fault) {
        if (const auto still = weak.lock()) complete(still, std::move(fault));
        begin();
    };
    if (worker.run(std::exchange(task->work, nullptr), on_done)) return;
    asio::post(io_, [this, weak = std::weak_ptr{task}, why = worker.why_not()] {
        if (const auto still = weak.lock()) complete(still, std::string{why} + " for the disk");
    });
}

void TaskPool::complete(const std::shared_ptr<Task>& task, std::string fault) {
    unheld_.erase(task);
    std::exchange(task->done, nullptr)(std::move(fault));
}

void TaskPool::stop() {
    stopped_ = true;
    waiting_.clear();
    unheld_.clear();
    const ano::TimePoint by = ano::Clock::now() + BackgroundTask::patience_at_the_end;    // one deadline for all threads
    for (BackgroundTask& worker : workers_) worker.stop(by);
}

http::Response answer_from(TaskPool& disk, std::function<http::Response()> work) {
    const auto held = std::make_shared<TaskPool::Ticket>();
    http::Response response = http::later([&disk, work = std::move(work),
                                           weak = std::weak_ptr{held}](const std::function<void(http::Response)>& respond) {
        const auto made = std::make_shared<http::Response>();
        TaskPool::Ticket ticket = disk.run(
            [made, work] { *made = work(); },
            [made, respond](const std::string& fault) { respond(fault.empty() ? std::move(*made) : http::error(503, fault)); });
        if (const auto still = weak.lock()) *still = std::move(ticket);
    });
    response.patient = true;
    response.needed = held;
    return response;
}

}    // namespace anogate
