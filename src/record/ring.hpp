// Keeps recent items, within limits of age and memory. No I/O.
//
// Flow:    ring.push(batch, cost, now);            // whenever there is a new item
//          ring.forget_until(now); ring.items()    // the recent items, oldest first
#pragma once
#include <ano/time.hpp>

#include <cstddef>
#include <deque>
#include <utility>

namespace anogate {

/// Items are dropped when they are older than `span`; the oldest ones also while all together cost more than `max_cost`.
template <class Item>
class Ring {
public:
    struct Kept {
        Item item;
        std::size_t cost = 0;    // bytes of memory
        ano::TimePoint at{};
    };

    Ring(ano::Duration span, std::size_t max_cost) : span_{span}, max_cost_{max_cost} {}

    /// An item that costs more than `max_cost` by itself is dropped together with all before it, so that there is never a gap.
    void push(Item item, std::size_t cost, ano::TimePoint now) {
        kept_.push_back({std::move(item), cost, now});
        cost_ += cost;
        while (cost_ > max_cost_) drop_oldest();
        forget_until(now);
    }
    void forget_until(ano::TimePoint now) {
        while (!kept_.empty() && now - kept_.front().at > span_) drop_oldest();
    }
    /// A shorter span takes effect at the next call of push() or forget_until().
    void set_span(ano::Duration span) noexcept { span_ = span; }
    void clear() {
        kept_.clear();
        cost_ = 0;
    }
    const std::deque<Kept>& items() const noexcept { return kept_; }
    std::size_t cost() const noexcept { return cost_; }
    ano::Duration span() const noexcept { return span_; }
    /// The age of the oldest item at `now`; 0: empty.
    ano::Duration reach(ano::TimePoint now) const noexcept { return kept_.empty() ? ano::Duration{} : now - kept_.front().at; }

private:
    void drop_oldest() {
        cost_ -= kept_.front().cost;
        kept_.pop_front();
    }

    ano::Duration span_;
    std::size_t max_cost_;
    std::deque<Kept> kept_;
    std::size_t cost_ = 0;
};

}    // namespace anogate
