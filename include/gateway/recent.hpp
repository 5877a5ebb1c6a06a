// Which frames came or went lately.
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/ids.hpp>
#include <gateway/treatment.hpp>

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

/// What several stations may well say in the very same words: the question of a host to everybody who they are (0xE0).
constexpr bool asked_by_many(ano::FrameView frame) noexcept {
    return frame.id() == 0xE0 && frame.destination() == ano::address::broadcast && ano::address::is_host(frame.source());
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

    /// What was remembered of `key` less than `window` before `now`, or nullptr. Valid until the next put().
    Value* find(std::uint64_t key, ano::TimePoint now) noexcept {
        Slot* slot = slot_of(key);
        return slot && now < slot->at + window_ ? &slot->value : nullptr;
    }
    /// When it was put in; for one that find() gave at the same `now`.
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

/// Keeps what was spread to several channels from coming back and going round: two gateways joined by two links.
class LoopGuard {
public:
    explicit LoopGuard(ano::Duration window = std::chrono::seconds{2}, std::size_t capacity = 16 * 1024)
        : window_{window}, sent_{window, capacity} {}

    /// The same bytes again by the channel that brought them first are a sender that repeats itself, or a ring that they
    /// entered elsewhere. Of so many one is kept back: a sender misses a thousandth, a ring ends, however long it is.
    static constexpr std::uint32_t repeats = 1000;
    /// How long a channel is taken for one that brings back what went there, after it did.
    static constexpr ano::Duration suspicion = std::chrono::seconds{60};

    /// The channel is new, one of `link`; what went to one that had its number before does not count.
    void open(ChannelId channel, LinkId link, ano::TimePoint now) noexcept {
        link_of_[index(channel)] = link;
        opened_at_[index(channel)] = now;
        suspect_until_[index(channel)] = ano::TimePoint::min();
    }
    /// A frame that came by `from` went, or could come back, by each of `channels`: Route::guarded.
    void remember(std::uint64_t key, ChannelId from, ChannelSet channels, ano::TimePoint now) noexcept {
        Sent sent{channels, {}, 0, from};
        if (const Sent* known = sent_.find(key, now)) {
            sent = *known;
            sent.channels |= channels;
            if (same_link(sent.from, from)) sent.from = from;
        }
        sent_.put(key, sent, now);
        quiet_at_ = now + window_;
    }
    /// A frame that was spread when it came by another channel: a copy, whichever way it took. One that was sent by one
    /// way of a ring comes back by another, and no channel that it was sent to brings it. Not by another peer of the same
    /// link: a sender with a new port says what it said before.
    bool copied(std::uint64_t key, ChannelId from, ano::TimePoint now) noexcept {
        if (now >= quiet_at_) return false;
        const Sent* known = sent_.find(key, now);
        return known && !same_link(known->from, from) && sent_.put_at(key) > opened_at_[index(from)];
    }
    /// A frame that came by `from` within the window after it went there; also the one of `repeats` that is kept back. A
    /// `common` one (asked_by_many()) is let through once, unless `from` is a channel that brings things back.
    bool looped(std::uint64_t key, ChannelId from, ano::TimePoint now, bool common = false) noexcept {
        if (now >= quiet_at_) return false;
        Sent* known = sent_.find(key, now);
        if (!known) return false;
        if (known->from == from && ++known->times % repeats == 0) return true;
        if (!known->channels.contains(from) || sent_.put_at(key) <= opened_at_[index(from)]) return false;
        if (!common) {
            suspect_until_[index(from)] = now + suspicion;
        } else if (!suspect(from, now) && !known->repeated.contains(from)) {
            known->repeated.insert(from);
            return false;
        }
        return true;
    }
    /// It brought back what nobody but the one who sent it can have said.
    bool suspect(ChannelId channel, ano::TimePoint now) const noexcept { return now < suspect_until_[index(channel)]; }

private:
    struct Sent {
        ChannelSet channels;
        ChannelSet repeated;        // of these, by which it came once more
        std::uint32_t times = 0;    // by `from` again
        ChannelId from{};           // by which it came and was let through
    };
    bool same_link(ChannelId a, ChannelId b) const noexcept { return link_of_[index(a)] == link_of_[index(b)]; }

    ano::Duration window_;
    Recent<Sent> sent_;
    ano::TimePoint quiet_at_ = ano::TimePoint::min();
    static constexpr std::array<ano::TimePoint, most_channels> never = [] {
        std::array<ano::TimePoint, most_channels> all;
        all.fill(ano::TimePoint::min());
        return all;
    }();
    std::array<ano::TimePoint, most_channels> opened_at_ = never, suspect_until_ = never;
    std::array<LinkId, most_channels> link_of_ = [] {    // each alone until it is opened
        std::array<LinkId, most_channels> all;
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<LinkId>(i);
        return all;
    }();
};

/// Of a frame that comes by several links of a group, lets one through.
class DuplicateGuard {
public:
    /// How long the link that brought a state must be silent before another may bring the same state again.
    static constexpr ano::Duration silence = std::chrono::milliseconds{200};

    explicit DuplicateGuard(ano::Duration window = std::chrono::seconds{2}, std::size_t capacity = 16 * 1024)
        : brought_{window, capacity} {}

    /// A frame came by `from`, a member of `group` (1 to 64). True: another member brought it less than the window
    /// before. A sender that repeats one and the same state, such as sticks that rest, is still heard when its link
    /// fails: once the member that brought it repeatedly is silent, the others count. That holds for frames a newer one
    /// may replace alone; a command never comes through twice.
    bool duplicate(std::uint64_t key, std::uint8_t group, LinkId from, Replaces replaces, ano::TimePoint now) noexcept {
        key = (key & ~std::uint64_t{0xFF}) | group;    // in place of HEAD, which all share
        heard_at_[index(from)] = now;
        if (const Brought* known = brought_.find(key, now); known && known->by != from) {
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
    std::array<ano::TimePoint, most_links> heard_at_{};
};

}    // namespace anogate
