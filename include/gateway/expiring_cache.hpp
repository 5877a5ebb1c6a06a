// Remembers what happened lately.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace anogate {

/// Remembers a value by key for a while. Bounded: where it is full, the oldest gives way. Constant time, no allocation
/// after construction.
template <class Value>
class ExpiringCache {
public:
    /// `capacity` is rounded up to a power of two.
    ExpiringCache(ano::Duration window, std::size_t capacity)
        : window_{window},
          shift_{64 - std::countr_zero(std::bit_ceil(std::max(capacity / ways, std::size_t{2})))},
          sets_{new Set[set_count()]} {}

    /// What was remembered of `key` less than `window` before `at`, or since, or nullptr. Valid until the next put().
    Value* find(std::uint64_t key, ano::TimePoint at) noexcept {
        Slot* slot = slot_of(key);
        return slot && at < slot->at + window_ ? &slot->value : nullptr;
    }
    /// When it was put in; for one that find() gave.
    ano::TimePoint put_at(std::uint64_t key) noexcept { return slot_of(key)->at; }
    /// Remembers `value` from `now` on, in place of what was known of `key`.
    void put(std::uint64_t key, const Value& value, ano::TimePoint now) noexcept {
        Slot* slot = slot_of(key);
        if (!slot) {
            Set& set = set_of(key);
            slot = std::min_element(set.begin(), set.end(), [](const Slot& a, const Slot& b) { return a.at < b.at; });
        }
        *slot = {key, now, value};
    }
    /// Calls `keep(key, value)`, which may change the value, for all that is remembered, and forgets those for which it is
    /// false. It walks all the memory: not for each frame.
    template <class Keep>
    void keep_if(Keep keep) {
        for (std::size_t i = 0; i < set_count(); ++i)
            for (Slot& slot : sets_[i])
                if (slot.at != ano::TimePoint::min() && !keep(slot.key, slot.value)) slot = {};
    }

    /// Calls `tell(key, at, value)` for all that was put in, however long ago. As keep_if(), not for each frame.
    template <class Tell>
    void for_each(Tell tell) const {
        for (std::size_t i = 0; i < set_count(); ++i)
            for (const Slot& slot : sets_[i])
                if (slot.at != ano::TimePoint::min()) tell(slot.key, slot.at, slot.value);
    }

private:
    static constexpr std::size_t ways = 4;
    struct Slot {
        std::uint64_t key = 0;
        ano::TimePoint at = ano::TimePoint::min();
        Value value{};
    };
    using Set = std::array<Slot, ways>;

    std::size_t set_count() const noexcept { return std::size_t{1} << (64 - shift_); }
    Set& set_of(std::uint64_t key) noexcept { return sets_[static_cast<std::size_t>(key * 0x9E3779B97F4A7C15u >> shift_)]; }
    Slot* slot_of(std::uint64_t key) noexcept {
        for (Slot& slot : set_of(key))
            if (slot.key == key && slot.at != ano::TimePoint::min()) return &slot;
        return nullptr;
    }

    ano::Duration window_;
    int shift_;
    std::unique_ptr<Set[]> sets_;
};

}    // namespace anogate
