// Which class sends next. Urgent precedes telemetry, telemetry precedes bulk, but each waiting class gets a tenth of the bytes.
#pragma once
#include <gateway/queue_policy.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace anogate {

/// For each byte that others send while a class waits, the class earns a ninth of a byte, which makes a tenth of all bytes. Bytes
/// that it sends because no higher class waits are subtracted, but never below zero. If the frame that would have used the earned
/// bytes is dropped, they are kept. So the class still sends some of its frames on a slow line, where frames become stale before
/// a tenth of the line can send one.
class ClassShares {
public:
    /// For each class the size of the frame that it sends next; 0: none waits.
    using Sizes = std::array<std::size_t, traffic_classes>;

    /// The class that sends next; traffic_classes when none waits.
    constexpr std::size_t choose(const Sizes& next) const noexcept {
        std::size_t highest = traffic_classes;
        for (std::size_t t = traffic_classes; t-- > 0;)
            if (next[t] > 0) highest = t;
        for (std::size_t t = highest + 1; t < traffic_classes; ++t)
            if (next[t] > 0 && due_[t] >= others_before_one * next[t]) return t;
        return highest;
    }
    /// The first frame of `chosen` is sent.
    constexpr void leaves(std::size_t chosen, const Sizes& next) noexcept {
        for (std::size_t t = 0; t < traffic_classes; ++t)
            if (next[t] > 0 && t != chosen) due_[t] += next[chosen];
        leaves_alone(chosen, next[chosen]);
    }
    /// The same when no other class waits.
    constexpr void leaves_alone(std::size_t chosen, std::size_t bytes) noexcept {
        due_[chosen] -= std::min(due_[chosen], others_before_one * bytes);
    }
    constexpr void clear() noexcept { due_ = {}; }

private:
    static constexpr std::uint64_t others_before_one = 9;
    std::array<std::uint64_t, traffic_classes> due_{};    // bytes of others; not used for the highest class
};

}    // namespace anogate
