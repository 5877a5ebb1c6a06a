// Asks a device many questions of one kind, in any order, and repeats those without an answer.
#pragma once
#include <ano/fault.hpp>
#include <host/task.hpp>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace ano::host {

/// The common part of Parameters, Commands and WaypointsGet. A question without an answer to any of its sends is asked once more,
/// before those that were not asked yet. If nothing was answered meanwhile, probe() is asked first; without an answer to it, the
/// task ends. The task also ends if more than max_missing questions have no answer.
class Gather : public Task {
public:
    static constexpr std::uint8_t rounds = 2;
    static constexpr std::size_t max_missing = 16;

    using Task::Task;
    Progress progress() const noexcept override { return {done_, total_}; }
    Duration max_duration() const noexcept override {
        return Task::max_duration() + std::chrono::seconds{4} * static_cast<int>(total_);
    }
    void ended(const Ended& ended, TimePoint now) final;

protected:
    /// Tags below this one are the numbers of questions.
    static constexpr std::uint32_t first_step = 0x8000'0001;

    /// Asks question(0) to question(n - 1), then calls gathered().
    void gather(std::size_t n, TimePoint now);
    /// The questions without an answer; valid in gathered().
    const std::vector<std::uint32_t>& missing() const noexcept { return missing_; }

    virtual Request question(std::uint32_t i) = 0;
    /// The answer to question i. False: it can't be used, and counts as missing.
    virtual bool took(std::uint32_t i, FrameView answer) = 0;
    virtual void gathered(TimePoint now) = 0;
    /// A question that every device answers.
    virtual Request probe() = 0;
    /// Another request of the task, with a tag of first_step or more, ended.
    virtual void step_ended(const Ended& ended, TimePoint now) = 0;
    /// The subject of the questions: "descriptions of parameters".
    virtual Fault subject() const = 0;

private:
    static constexpr std::size_t max_asked = 2 * Window::max_size;    // enough to keep the window full

    static constexpr std::uint32_t probing = first_step - 1;
    struct Item {
        std::uint8_t tried = 0;
        bool is_asked = false;    // in flight or queued
    };

    void ask_more(TimePoint now);
    void question_ended(const Ended& ended, TimePoint now);
    void without_answer(std::uint32_t i, const Ended& ended, TimePoint now);
    void requeue_in_flight();
    void stop_at(std::uint32_t i);

    std::size_t total_ = 0;
    std::size_t done_ = 0;
    std::size_t asked_ = 0;    // in flight or queued
    std::uint32_t next_ = 0;
    std::vector<Item> items_;
    std::vector<std::uint32_t> again_;
    std::vector<std::uint32_t> missing_;
};

}    // namespace ano::host
