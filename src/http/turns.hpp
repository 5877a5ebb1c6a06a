// A queue of those that wait for their turn.
#pragma once
#include <algorithm>
#include <deque>
#include <optional>
#include <utility>

namespace anogate::http {

/// First in, first out. The owner calls next() for one turn at a time, and lets the loop do its other work in between.
template <class Who>
class Turns {
public:
    /// True: no call of next() is scheduled; the caller must schedule one.
    bool wait(Who who) {
        waiting_.push_back(std::move(who));
        return !std::exchange(arranged_, true);
    }
    /// Removes `who` from the queue.
    void leave(const Who& who) { std::erase(waiting_, who); }
    /// The scheduled call: returns who is next. If is_arranged() afterwards, the caller must schedule the next call.
    std::optional<Who> next() {
        std::optional<Who> who;
        if (!waiting_.empty()) {
            who = std::move(waiting_.front());
            waiting_.pop_front();
        }
        arranged_ = !waiting_.empty();
        return who;
    }
    bool is_arranged() const noexcept { return arranged_; }
    /// A scheduled call of next() still comes and returns std::nullopt.
    void clear() noexcept { waiting_.clear(); }

private:
    std::deque<Who> waiting_;
    bool arranged_ = false;
};

}    // namespace anogate::http
