// A queue from one thread to another; neither thread ever waits for the other.
#pragma once
#include <atomic>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace anogate {

/// Lock-free. One thread pushes, another one pops; memory is allocated once, by the constructor.
template <class T>
class ThreadQueue {
public:
    explicit ThreadQueue(std::size_t places) : places_(places) {}

    /// For the pushing thread: once true, it stays true until the next push().
    bool has_room() const noexcept { return pushed_ - popped_ < places_.size(); }
    /// False: the queue is full.
    bool push(T item) {
        if (!has_room()) return false;
        places_[pushed_ % places_.size()] = std::move(item);
        ++pushed_;
        return true;
    }
    bool empty() const noexcept { return popped_ == pushed_; }
    std::optional<T> pop() {
        if (empty()) return std::nullopt;
        T item = std::exchange(places_[popped_ % places_.size()], {});
        ++popped_;
        return item;
    }

private:
    std::vector<T> places_;
    std::atomic<std::size_t> pushed_{0}, popped_{0};
};

}    // namespace anogate
