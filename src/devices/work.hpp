// What a job does, step by step.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <devices/device_net.hpp>
#include <devices/notes.hpp>
#include <host/description_cache.hpp>
#include <host/task.hpp>

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

/// How a job ended, as the answer to who asked for it.
struct WorkEnd {
    unsigned status = 200;
    std::string result{};    // JSON; of 200, else of what is half done
    std::string error;       // a clause for people; of 200 it may say what is to be known all the same
    std::string what;        // a word for programs; of 200 empty
    ano::host::Evidence evidence{};
    bool is_cancelled = false;
    bool is_exact = false;    // the result is as exact_json() makes it
};

/// As `end` is told: done has a status of 200 and no result yet.
WorkEnd end_of(const ano::host::End& end);
/// `what` of the status.
WorkEnd work_fault(unsigned status, std::string error);

/// What works of all kinds use.
struct WorkPlace {
    ano::host::Device& device;
    ano::host::DescriptionCache& cache;
    DeviceNet& net;
    Notes& notes;
    /// Why the device may not be changed just now, in words; empty: it may.
    std::function<std::string()> refusal{};
};

/// It is driven by its job: start() once, then run() whenever a request of its device may have ended, until end(). No function of it is
/// called from within one of its tasks.
class Work {
public:
    virtual ~Work() = default;
    virtual void start(ano::TimePoint now) = 0;
    virtual void run(ano::TimePoint now) = 0;
    /// Ends it, soon: what has to be put back is put back first.
    virtual void cancel(ano::TimePoint now) = 0;
    const std::optional<WorkEnd>& end() const noexcept { return end_; }

    virtual ano::host::Progress progress() const { return {}; }
    /// In words, what it does now.
    virtual std::string message() const { return {}; }
    /// Every frame that passes, beside the device's own take(). It sends nothing.
    virtual void hear(ano::FrameView /*frame*/, ano::TimePoint /*now*/) {}
    /// What is half done when it is left as it is now, where cancel() did not end it at once.
    virtual std::string half_done() const { return "it is left as it is"; }
    /// When run() has to be called, beside Device::due().
    virtual std::optional<ano::TimePoint> due() const { return std::nullopt; }
    /// It waits until somebody says go on; false: it does not.
    virtual bool is_waiting() const { return false; }
    virtual bool go_on(ano::TimePoint /*now*/) { return false; }
    /// What is shown beside, as JSON; empty: nothing.
    virtual std::string step() const { return {}; }

protected:
    void finish(WorkEnd end) {
        if (!end_) end_ = std::move(end);
    }

private:
    std::optional<WorkEnd> end_;
};

/// One task after the other.
class TaskWork : public Work {
public:
    explicit TaskWork(const WorkPlace& place) : place_{place} {}

    void run(ano::TimePoint now) final;
    void cancel(ano::TimePoint now) override;
    ano::host::Progress progress() const override;

protected:
    WorkPlace& place() noexcept { return place_; }
    const WorkPlace& place() const noexcept { return place_; }
    /// `task` is the one that is waited for: the caller starts it.
    template <class T>
    T& next(std::unique_ptr<T> task) {
        T& now_running = *task;
        former_ = std::move(task_);
        task_ = std::move(task);
        return now_running;
    }
    const ano::host::Task* task() const noexcept { return task_.get(); }
    /// The task ended as is told. A task that ended otherwise than done ends the work as it did, unless this says otherwise.
    virtual void done(const ano::host::Task& task, ano::TimePoint now) = 0;
    virtual void failed(const ano::host::Task& task, ano::TimePoint /*now*/) { finish(end_of(*task.end())); }
    /// Behind every run().
    virtual void look(ano::TimePoint /*now*/) {}

private:
    WorkPlace place_;
    std::unique_ptr<ano::host::Task> task_, former_;
};

}    // namespace anogate
