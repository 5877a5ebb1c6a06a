// Asks a device many questions of one kind, in any order, and repeats those without an answer.
#pragma once
#include <host/task.hpp>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace ano::host {

/// What Parameters, Commands and WaypointsGet have in common. A question that got no answer to any of its sends is asked once more,
/// before those that were not asked yet. When nothing was answered meanwhile, probe() is asked first: without an answer to that, the
/// task ends. It also ends when more than max_missing questions stay without an answer.
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
    /// The questions that got no answer; valid in gathered().
    const std::vector<std::uint32_t>& missing() const noexcept { return missing_; }

    virtual Request question(std::uint32_t i) = 0;
    /// The answer to question i. False: it is of no use, as if there had been none.
    virtual bool took(std::uint32_t i, FrameView answer) = 0;
    virtual void gathered(TimePoint now) = 0;
    /// A question that every device answers.
    virtual Request probe() = 0;
    /// Another request of the task ended, whose tag is first_step or more.
    virtual void step_ended(const Ended& ended, TimePoint now) = 0;
    /// What the questions are for: "descriptions of parameters".
    virtual std::string_view subject() const noexcept = 0;

private:
    static constexpr std::size_t max_asked = 2 * Window::max_size;    // enough to keep the window full

    static constexpr std::uint32_t probing = first_step - 1;
    struct Item {
        std::uint8_t tried = 0;
        bool is_asked = false;    // on its way or queued
    };

    void ask_more(TimePoint now);
    void question_ended(const Ended& ended, TimePoint now);
    void without_answer(std::uint32_t i, const Ended& ended, TimePoint now);
    void take_back();
    void stop_at(std::uint32_t i);

    std::size_t total_ = 0;
    std::size_t done_ = 0;
    std::size_t asked_ = 0;    // on their way or queued
    std::uint32_t next_ = 0;
    std::vector<Item> items_;
    std::vector<std::uint32_t> again_;
    std::vector<std::uint32_t> missing_;
};

}    // namespace ano::host
