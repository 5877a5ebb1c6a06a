// Both checks of any stretch of a buffer in constant time, after each of its bytes was summed once.
#pragma once
#include <ano/room.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace ano {

/// Sums over a buffer from the place that begin() sets. Allocates only at construction.
class PrefixSums {
public:
    explicit PrefixSums(std::size_t capacity);

    void begin(std::size_t at) noexcept {
        end_ = at;
        sum_[at] = add_[at] = 0;
    }
    /// Sums the bytes before `to`, and up to 256 more if they are there; `bytes` is the filled part of the buffer.
    void extend(std::span<const std::uint8_t> bytes, std::size_t to) noexcept;
    /// The buffer's content moved to its front by `distance` bytes; what was summed stays summed.
    void move_front(std::size_t distance) noexcept;
    /// The bytes before this are summed.
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

    Room<std::uint8_t> sum_;    // sum_[i]: the sum of the bytes before i
    Room<std::uint8_t> add_;    // add_[i]: the sum of sum_[k + 1] for the places k before i
    Room<std::uint8_t> gap_;    // gap_[i]: sum_[i] minus byte i, the sum before a frame whose SC stands at i
    std::size_t end_ = 0;
};

}    // namespace ano
