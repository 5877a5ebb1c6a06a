// Both checks of any range of a buffer in constant time, after each of its bytes was added once.
#pragma once
#include <ano/lazy_array.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace ano {

/// Sums over a buffer from the position set by begin(). Allocates only at construction.
class PrefixSums {
public:
    explicit PrefixSums(std::size_t capacity);

    void begin(std::size_t at) noexcept {
        end_ = at;
        sum_[at] = add_[at] = 0;
    }
    /// Adds the bytes before `to`, and up to 256 more if available; `bytes` is the filled part of the buffer.
    void extend(std::span<const std::uint8_t> bytes, std::size_t to) noexcept;
    /// The content of the buffer was moved to its beginning by `distance` bytes; the sums are kept.
    void move_front(std::size_t distance) noexcept;
    /// The sums include the bytes before this.
    std::size_t end() const noexcept { return end_; }

    /// Whether SC at `to` is the sum over [from, to); begin() <= from <= to < end(). This check alone refuses 255 of 256 bad frames.
    bool sum_holds(std::size_t from, std::size_t to) const noexcept { return sum_[from] == gap_[to]; }
    /// For loops: sum_holds(from, to) is sums()[from] == gaps()[to].
    const std::uint8_t* sums() const noexcept { return sum_.get(); }
    const std::uint8_t* gaps() const noexcept { return gap_.get(); }
    /// The additional check over [from, to); to <= end().
    std::uint8_t add(std::size_t from, std::size_t to) const noexcept {
        return static_cast<std::uint8_t>(add_[to] - add_[from] - (to - from) * sum_[from]);
    }

private:
    void extend_to(const std::uint8_t* bytes, std::size_t to) noexcept;

    LazyArray<std::uint8_t> sum_;    // sum_[i]: the sum of the bytes before i
    LazyArray<std::uint8_t> add_;    // add_[i]: the sum of sum_[k + 1] for all k < i
    LazyArray<std::uint8_t> gap_;    // gap_[i]: sum_[i] minus byte i, the sum before a frame whose SC is at i
    std::size_t end_ = 0;
};

}    // namespace ano
