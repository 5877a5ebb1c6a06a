// A cache of recent values.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace anogate {

/// Stores a value by key for a limited time. Bounded: when it is full, the oldest value is replaced. Constant time, no allocation
/// after construction. Parts that were never written use address space but no memory.
template <class Value>
class ExpiringCache {
    static_assert(std::is_trivially_copyable_v<Value>);

public:
    /// `capacity` is rounded up to a power of two. Throws std::bad_alloc.
    ExpiringCache(ano::Duration window, std::size_t capacity)
        : window_{window},
          shift_{64 - std::countr_zero(std::bit_ceil(std::max(capacity / ways, std::size_t{2})))},
          sets_{static_cast<Set*>(std::calloc(set_count(), sizeof(Set)))} {
        if (!sets_) throw std::bad_alloc{};
    }

    /// The value of `key` that was stored less than `window` before `at`; nullptr: none. Valid until the next put().
    Value* find(std::uint64_t key, ano::TimePoint at) noexcept {
        Slot* slot = slot_of(key);
        return slot && at < time_of(*slot) + window_ ? &slot->value : nullptr;
    }
    /// When the value was stored; only for a key that find() found.
    ano::TimePoint stored_at(std::uint64_t key) noexcept { return time_of(*slot_of(key)); }
    /// Stores `value` with the time `now`; it replaces an earlier value of `key`.
    void put(std::uint64_t key, const Value& value, ano::TimePoint now) noexcept {
        Slot* slot = slot_of(key);
        if (!slot) {
            Set& set = set_of(key);
            slot = std::min_element(set.begin(), set.end(), [](const Slot& a, const Slot& b) { return a.at < b.at; });
        }
        *slot = {key, stored(now), value};
    }
    /// Calls `keep(key, value)`, which may change the value, for all values, and removes those for which it returns false. It
    /// walks through all the memory, which is too slow for each frame.
    template <class Keep>
    void keep_if(Keep keep) {
        for (std::size_t i = 0; i < set_count(); ++i)
            for (Slot& slot : sets_[i])
                if (slot.at != empty && !keep(slot.key, slot.value)) slot = {};
    }

    /// Calls `visit(key, at, value)` for all values, also expired ones. Too slow for each frame, like keep_if().
    template <class Visit>
    void for_each(Visit visit) const {
        for (std::size_t i = 0; i < set_count(); ++i)
            for (const Slot& slot : sets_[i])
                if (slot.at != empty) visit(slot.key, time_of(slot), slot.value);
    }

private:
    static constexpr std::size_t ways = 4;
    static constexpr std::uint64_t empty = 0;
    struct Slot {
        std::uint64_t key = 0;
        std::uint64_t at = empty;    // in an encoding that keeps the order of time; TimePoint::min() is 0
        Value value{};
    };
    using Set = std::array<Slot, ways>;
    // From calloc(): an empty slot is all zeros, and pages that were never written to are not in memory.
    struct Free {
        void operator()(Set* sets) const noexcept { std::free(sets); }
    };

    static constexpr std::uint64_t sign = std::uint64_t{1} << 63;
    static std::uint64_t stored(ano::TimePoint at) noexcept {
        return static_cast<std::uint64_t>(at.time_since_epoch().count()) ^ sign;
    }
    static ano::TimePoint time_of(const Slot& slot) noexcept {
        return ano::TimePoint{ano::Duration{static_cast<ano::Duration::rep>(slot.at ^ sign)}};
    }

    std::size_t set_count() const noexcept { return std::size_t{1} << (64 - shift_); }
    Set& set_of(std::uint64_t key) noexcept { return sets_[static_cast<std::size_t>(key * 0x9E3779B97F4A7C15u >> shift_)]; }
    Slot* slot_of(std::uint64_t key) noexcept {
        for (Slot& slot : set_of(key))
            if (slot.key == key && slot.at != empty) return &slot;
        return nullptr;
    }

    ano::Duration window_;
    int shift_;
    std::unique_ptr<Set[], Free> sets_;
};

}    // namespace anogate
