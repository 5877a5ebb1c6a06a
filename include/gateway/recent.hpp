// Which frames came or went lately.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/ids.hpp>
#include <gateway/queue_policy.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>

namespace anogate {

/// What a frame is known by: its header and both checks. The same bytes always have the same key; two frames of one
/// sender that differ share a key once in 65,536.
inline std::uint64_t key_of(ano::FrameView frame) noexcept {
    std::array<std::uint8_t, 8> bytes;
    std::memcpy(bytes.data(), frame.bytes().data(), ano::header_size);
    const ano::Checks checks = frame.checks();
    bytes[6] = checks.sum;
    bytes[7] = checks.add;
    return std::bit_cast<std::uint64_t>(bytes);
}

/// Remembers a value by key for a while. Bounded: where it is full, the oldest gives way. Constant time, no allocation
/// after construction.
template <class Value>
class Recent {
public:
    /// `capacity` is rounded up to a power of two.
    Recent(ano::Duration window, std::size_t capacity)
        : window_{window},
          shift_{64 - std::countr_zero(std::bit_ceil(std::max(capacity / ways, std::size_t{2})))},
          sets_{new Set[std::size_t{1} << (64 - shift_)]} {}

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

private:
    static constexpr std::size_t ways = 4;
    struct Slot {
        std::uint64_t key = 0;
        ano::TimePoint at = ano::TimePoint::min();
        Value value{};
    };
    using Set = std::array<Slot, ways>;

    Set& set_of(std::uint64_t key) noexcept { return sets_[key * 0x9E3779B97F4A7C15u >> shift_]; }
    Slot* slot_of(std::uint64_t key) noexcept {
        for (Slot& slot : set_of(key))
            if (slot.key == key && slot.at != ano::TimePoint::min()) return &slot;
        return nullptr;
    }

    ano::Duration window_;
    int shift_;
    std::unique_ptr<Set[]> sets_;
};

/// Of a frame that comes by several links of a group, lets one through.
class DuplicateGuard {
public:
    /// How long the link that brought a state must be silent before another may bring the same state again.
    static constexpr ano::Duration silence = std::chrono::milliseconds{200};

    explicit DuplicateGuard(ano::Duration window = std::chrono::seconds{2}, std::size_t capacity = 16 * 1024)
        : brought_{window, capacity} {}

    /// A frame came by `from`, a member of `group` (1 to 64); it `arrived` before, where it waited to be read. True: another member brought it less than the window
    /// before. A sender that repeats one and the same state, such as sticks that rest, is still heard when its link
    /// fails: once the member that brought it repeatedly is silent, the others count. That holds for frames a newer one
    /// may replace alone; a command never comes through twice.
    bool duplicate(std::uint64_t key, std::uint8_t group, LinkId from, Replaces replaces, ano::TimePoint now,
                   ano::TimePoint arrived = ano::TimePoint::max()) noexcept {
        key = (key & ~std::uint64_t{0xFF}) | group;    // in place of HEAD, which all share
        heard_at_[index(from)] = now;
        if (const Brought* known = brought_.find(key, std::min(arrived, now)); known && known->by != from) {
            const bool failed = now - heard_at_[index(known->by)] >= silence;
            if (!(replaces != Replaces::nothing && known->repeats && failed)) return true;
            brought_.put(key, {from, true}, now);
        } else {
            brought_.put(key, {from, known != nullptr}, now);
        }
        return false;
    }

private:
    struct Brought {
        LinkId by{};
        bool repeats = false;
    };
    Recent<Brought> brought_;
    std::array<ano::TimePoint, max_links> heard_at_{};
};

}    // namespace anogate
