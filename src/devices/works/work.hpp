// The work of a job, step by step.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <devices/crash_journal.hpp>
#include <devices/device_net.hpp>
#include <devices/device_texts.hpp>
#include <host/commands.hpp>
#include <host/description_cache.hpp>
#include <host/task.hpp>

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

/// How a job ended, as the answer to the client.
struct WorkEnd {
    unsigned status = 200;
    std::string result{};    // JSON; the result for 200, otherwise the half-done state
    ano::Fault fault{};      // for 200 a remark, or empty
    std::string what{};      // a word for programs; empty for 200
    ano::host::Evidence evidence{};
    bool is_cancelled = false;
    bool is_exact = false;    // `result` is in the form of exact_json()
};

/// Converts `end`; a task that is done gives status 200 without a result. `texts`: of the device.
WorkEnd end_of(const ano::host::End& end, const DeviceTexts& texts);
/// With the status of `fault`, and the `what` that belongs to it.
WorkEnd work_fault(ano::Fault fault);

/// The common data of all works.
struct WorkPlace {
    ano::host::Device& device;
    ano::host::DescriptionCache& cache;
    ano::host::CommandCache& commands;
    DeviceNet& net;
    CrashJournal& journal;
    const DeviceTexts& texts;
    /// Why the device may not be changed now; empty: it may be changed.
    std::function<ano::Fault()> refusal{};
    /// Its tasks yield to those of clients that may control.
    bool yields = false;
};

/// Driven by its job: start() once, then run() whenever a request to the device may have ended, until end() is set. No function
/// is called from within one of its tasks.
class Work {
public:
    virtual ~Work() = default;
    virtual void start(ano::TimePoint now) = 0;
    virtual void run(ano::TimePoint now) = 0;
    /// Ends the work soon, after restoring what must be restored.
    virtual void cancel(ano::TimePoint now) = 0;
    const std::optional<WorkEnd>& end() const noexcept { return end_; }

    virtual ano::host::Progress progress() const { return {}; }
    /// The current action, as text for the user.
    virtual std::string message() const { return {}; }
    /// Called for every passing frame, in addition to Device::take(). Must not send.
    virtual void receive(ano::FrameView /*frame*/, ano::TimePoint /*now*/) {}
    /// The half-done state if it is stopped now, when cancel() does not end it at once.
    virtual ano::Fault half_done() const { return {"unchanged"}; }
    /// When run() must be called, in addition to Device::due().
    virtual std::optional<ano::TimePoint> due() const { return std::nullopt; }
    /// Whether run() must be called at once: a request ended while frames were sent.
    virtual bool is_ready() const noexcept { return false; }
    /// Whether it waits for go_on(). go_on() returns false if it does not wait.
    virtual bool is_waiting() const { return false; }
    virtual bool go_on(ano::TimePoint /*now*/) { return false; }
    /// Further data of the present step, as JSON; empty: none.
    virtual std::string step() const { return {}; }

protected:
    void finish(WorkEnd end) {
        if (!end_) end_ = std::move(end);
    }

private:
    std::optional<WorkEnd> end_;
};

/// A work that runs tasks one after another.
class TaskWork : public Work {
public:
    explicit TaskWork(const WorkPlace& place) : place_{place} {}

    void run(ano::TimePoint now) final;
    bool is_ready() const noexcept final { return task_ && task_->end() && task_.get() != handled_; }
    void cancel(ano::TimePoint now) override;
    ano::host::Progress progress() const override;

protected:
    WorkPlace& place() noexcept { return place_; }
    const WorkPlace& place() const noexcept { return place_; }
    const DeviceTexts& texts() const noexcept { return place_.texts; }
    /// `task` becomes the current task; the caller starts it.
    template <class T>
    T& next(std::unique_ptr<T> task) {
        T& now_running = *task;
        now_running.yield_to_others(place_.yields);
        former_ = std::move(task_);
        task_ = std::move(task);
        return now_running;
    }
    const ano::host::Task* task() const noexcept { return task_.get(); }
    /// Called when the task has ended: done() on success, otherwise failed(), which by default ends the work in the same way.
    virtual void done(const ano::host::Task& task, ano::TimePoint now) = 0;
    virtual void failed(const ano::host::Task& task, ano::TimePoint /*now*/) { finish(end_of(*task.end(), texts())); }
    /// Called after every run().
    virtual void look(ano::TimePoint /*now*/) {}

private:
    WorkPlace place_;
    std::unique_ptr<ano::host::Task> task_, former_;
    const ano::host::Task* handled_ = nullptr;    // its end
};

}    // namespace anogate
