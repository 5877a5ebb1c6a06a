// Whose turn it is.
#pragma once
#include <algorithm>
#include <deque>
#include <optional>
#include <utility>

namespace anogate::http {

/// Those who wait, whoever has waited longest first. The turns themselves are given by who asks next(), one at a time: between two of
/// them the loop does what came in meanwhile.
template <class Who>
class Turns {
public:
    /// True: nobody waited, so that somebody has to arrange for a call of next().
    bool wait(Who who) {
        waiting_.push_back(std::move(who));
        return !std::exchange(arranged_, true);
    }
    /// Its place is another's.
    void leave(const Who& who) { std::erase(waiting_, who); }
    /// As arranged. When more are waiting, the next turn is to be arranged as well: is_arranged().
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
    /// What is arranged comes all the same, and gives nobody a turn.
    void clear() noexcept { waiting_.clear(); }

private:
    std::deque<Who> waiting_;
    bool arranged_ = false;
};

}    // namespace anogate::http
