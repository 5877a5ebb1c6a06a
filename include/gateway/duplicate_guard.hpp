// Passes only one copy of a frame that is received on several links of a group.
#pragma once
#include <ano/time.hpp>
#include <gateway/expiring_cache.hpp>
#include <gateway/ids.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace anogate {

class DuplicateGuard {
public:
    /// How long a link must receive nothing before another link of the group may pass the state that the first one passed.
    static constexpr ano::Duration silence = std::chrono::milliseconds{200};

    /// How long a frame is stored.
    static constexpr ano::Duration usual_window = std::chrono::seconds{2};

    explicit DuplicateGuard(ano::Duration window = usual_window, std::size_t capacity = 16 * 1024) : brought_{window, capacity} {}

    enum class Kind : std::uint8_t {
        state,     // a newer one may replace it
        answer,    // from a device to a host
        other,
    };

    /// A frame with this frame_key() was received on `from`, a link of `group` (1 to 64). `arrived` is earlier than `now` if the
    /// frame waited to be read. True: another link of the group received it less than the window before.
    /// A sender that repeats the same state, such as sticks at rest, still gets through when its link fails: if the link that
    /// received the repeats is silent, the others count. An answer is new if a question or an order was sent to the group since,
    /// even if it is equal to the previous one. Other frames never pass twice: they may be commands.
    bool duplicate(std::uint64_t key, std::uint8_t group, LinkId from, Kind kind, ano::TimePoint now,
                   ano::TimePoint arrived = ano::TimePoint::max()) noexcept {
        key = (key & ~std::uint64_t{0xFF}) | group;    // 56 bits of the key are enough to distinguish frames
        heard_at_[index(from)] = now;
        if (const Brought* known = brought_.find(key, std::min(arrived, now)); known && known->by != from) {
            const bool failed = now - heard_at_[index(known->by)] >= silence;
            const bool is_new = kind == Kind::state    ? known->repeats && failed
                                : kind == Kind::answer ? asked_at_[group] > brought_.stored_at(key)
                                                       : false;
            if (!is_new) return true;
            brought_.put(key, {from, true}, now);
        } else {
            brought_.put(key, {from, known != nullptr}, now);
        }
        return false;
    }

    /// Call when a question or an order is sent on a link of `group`.
    void asked(std::uint8_t group, ano::TimePoint now) noexcept { asked_at_[group] = now; }

    /// Call when the link is removed. The frames it received stay known to the other links of its group.
    void remove_link(LinkId link) {
        heard_at_[index(link)] = {};
        brought_.keep_if([link](std::uint64_t, Brought& brought) {
            if (brought.by == link) brought.by = nobody;
            return true;
        });
    }
    /// Call when no link has this group any more.
    void remove_group(std::uint8_t group) {
        brought_.keep_if([group](std::uint64_t key, const Brought&) { return (key & 0xFF) != group; });
    }

    /// A frame that was received on a link of a group.
    struct Memory {
        std::uint64_t key = 0;
        bool repeats = false;
        ano::TimePoint at{};
    };
    /// The frames that `link` was the first, or the last, to receive after `since`; for restore() in the program that continues
    /// this one.
    std::vector<Memory> brought_by(LinkId link, ano::TimePoint since) const {
        std::vector<Memory> all;
        brought_.for_each([&](std::uint64_t key, ano::TimePoint at, const Brought& brought) {
            if (brought.by == link && at > since) all.push_back({key, brought.repeats, at});
        });
        return all;
    }
    /// `link`, now of `group`, received the frame.
    void restore(const Memory& memory, std::uint8_t group, LinkId link) noexcept {
        brought_.put((memory.key & ~std::uint64_t{0xFF}) | group, {link, memory.repeats}, memory.at);
        heard_at_[index(link)] = std::max(heard_at_[index(link)], memory.at);
    }

private:
    static constexpr LinkId nobody{max_links};    // replaces removed links; nothing is received on it
    struct Brought {
        LinkId by{};
        bool repeats = false;
    };
    ExpiringCache<Brought> brought_;
    std::array<ano::TimePoint, max_links + 1> heard_at_{};
    std::array<ano::TimePoint, max_links + 1> asked_at_{};    // by group
};

}    // namespace anogate
