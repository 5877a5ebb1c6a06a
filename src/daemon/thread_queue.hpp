// From one thread to one other; neither waits for the other, whatever happens to it.
#pragma once
#include <atomic>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace anogate {

/// Without locks. One thread pushes, one other pops; the room is taken once, at the start.
template <class T>
class ThreadQueue {
public:
    explicit ThreadQueue(std::size_t places) : places_(places) {}

    /// Asked by the one who pushes: for him it stays true.
    bool has_room() const noexcept { return pushed_ - popped_ < places_.size(); }
    /// False: there is no room.
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
