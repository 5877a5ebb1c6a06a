// A queue of sessions that wait for their turn.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace anogate::http {

/// Entries with `has_priority` precede all others. Among equals, the clients (`of`) get turns in rotation: however many entries of
/// a client wait, every other client has a turn between two of them. The owner calls next() for one turn at a time, and the loop
/// does its other work in between.
template <class Who, class Client>
class Turns {
public:
    /// True: no call of next() is scheduled; the caller must schedule one.
    bool wait(Who who, const Client& of, bool has_priority) {
        (has_priority ? first_ : others_).wait(std::move(who), of);
        return !std::exchange(arranged_, true);
    }
    /// Removes `who` from the queue.
    void leave(const Who& who) {
        first_.leave(who);
        others_.leave(who);
    }
    /// The scheduled call: returns the next entry. If is_arranged() afterwards, the caller must schedule the next call.
    std::optional<Who> next() {
        auto who = first_.next();
        if (!who) who = others_.next();
        arranged_ = !first_.is_empty() || !others_.is_empty();
        return who;
    }
    bool is_arranged() const noexcept { return arranged_; }
    /// True if an entry with `has_priority` waits.
    bool has_priority_entry() const noexcept { return !first_.is_empty(); }
    /// Removes all entries. A scheduled call of next() is still made and returns std::nullopt.
    void clear() noexcept {
        first_.clear();
        others_.clear();
    }

private:
    /// A queue in rounds; in each round, a client has one turn.
    class Line {
    public:
        void wait(Who who, const Client& of) {
            const bool was_in_this = std::find(served_.begin(), served_.end(), of) != served_.end();
            std::uint64_t round = was_in_this ? round_ + 1 : round_;
            for (const One& one : waiting_)
                if (one.of == of) round = std::max(round, one.round + 1);
            waiting_.push_back({std::move(who), of, round});
        }
        void leave(const Who& who) {
            std::erase_if(waiting_, [&](const One& one) { return one.who == who; });
        }
        std::optional<Who> next() {
            const auto first = std::min_element(waiting_.begin(), waiting_.end(),
                                                [](const One& a, const One& b) { return a.round < b.round; });
            if (first == waiting_.end()) return std::nullopt;
            if (std::exchange(round_, first->round) != round_) served_.clear();
            served_.push_back(first->of);
            std::optional<Who> who{std::move(first->who)};
            waiting_.erase(first);
            return who;
        }
        bool is_empty() const noexcept { return waiting_.empty(); }
        void clear() noexcept { waiting_.clear(); }

    private:
        struct One {
            Who who;
            Client of;
            std::uint64_t round;
        };
        std::vector<One> waiting_;      // in the order of wait()
        std::vector<Client> served_;    // in this round
        std::uint64_t round_ = 0;
    };

    Line first_, others_;
    bool arranged_ = false;
};

}    // namespace anogate::http
