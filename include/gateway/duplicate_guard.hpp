// Lets only one copy through of a frame that comes by several links of a group.
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
    /// How long the link that brought a state must be silent before another link may bring the same state again.
    static constexpr ano::Duration silence = std::chrono::milliseconds{200};

    /// How long a frame is remembered.
    static constexpr ano::Duration usual_window = std::chrono::seconds{2};

    explicit DuplicateGuard(ano::Duration window = usual_window, std::size_t capacity = 16 * 1024) : brought_{window, capacity} {}

    enum class Kind : std::uint8_t {
        state,     // a newer one may replace it
        answer,    // of a device to a host
        other,
    };

    /// A frame of this frame_key() came by `from`, a link of `group` (1 to 64); `arrived` is earlier than `now` if it waited to
    /// be read. True: another link of the group brought it less than the window before. A sender that repeats the same state,
    /// such as sticks at rest, still gets through when its link fails: once the link that brought the repeats is silent, the
    /// others count. An answer is new if a question or an order went to the group since: it may be equal to the one before. Everything else
    /// never comes through twice: it may be a command.
    bool duplicate(std::uint64_t key, std::uint8_t group, LinkId from, Kind kind, ano::TimePoint now,
                   ano::TimePoint arrived = ano::TimePoint::max()) noexcept {
        key = (key & ~std::uint64_t{0xFF}) | group;    // 56 bits of the key are enough to distinguish frames
        heard_at_[index(from)] = now;
        if (const Brought* known = brought_.find(key, std::min(arrived, now)); known && known->by != from) {
            const bool failed = now - heard_at_[index(known->by)] >= silence;
            const bool is_new = kind == Kind::state    ? known->repeats && failed
                                : kind == Kind::answer ? asked_at_[group] > brought_.put_at(key)
                                                       : false;
            if (!is_new) return true;
            brought_.put(key, {from, true}, now);
        } else {
            brought_.put(key, {from, known != nullptr}, now);
        }
        return false;
    }

    /// To be called when a question or an order leaves by a link of `group`.
    void asked(std::uint8_t group, ano::TimePoint now) noexcept { asked_at_[group] = now; }

    /// To be called when the link is removed. What it brought stays known to the other links of its group.
    void remove_link(LinkId link) {
        heard_at_[index(link)] = {};
        brought_.keep_if([link](std::uint64_t, Brought& brought) {
            if (brought.by == link) brought.by = nobody;
            return true;
        });
    }
    /// To be called when no link has this group any more.
    void remove_group(std::uint8_t group) {
        brought_.keep_if([group](std::uint64_t key, const Brought&) { return (key & 0xFF) != group; });
    }

    /// A frame that came by a link of a group.
    struct Memory {
        std::uint64_t key = 0;
        bool repeats = false;
        ano::TimePoint at{};
    };
    /// The frames that `link` brought first, or last, after `since`; for restore() in the program that continues from this one.
    std::vector<Memory> brought_by(LinkId link, ano::TimePoint since) const {
        std::vector<Memory> all;
        brought_.for_each([&](std::uint64_t key, ano::TimePoint at, const Brought& brought) {
            if (brought.by == link && at > since) all.push_back({key, brought.repeats, at});
        });
        return all;
    }
    /// `link`, now of `group`, brought the frame.
    void restore(const Memory& memory, std::uint8_t group, LinkId link) noexcept {
        brought_.put((memory.key & ~std::uint64_t{0xFF}) | group, {link, memory.repeats}, memory.at);
        heard_at_[index(link)] = std::max(heard_at_[index(link)], memory.at);
    }

private:
    static constexpr LinkId nobody{max_links};    // stands for removed links, which are silent
    struct Brought {
        LinkId by{};
        bool repeats = false;
    };
    ExpiringCache<Brought> brought_;
    std::array<ano::TimePoint, max_links + 1> heard_at_{};
    std::array<ano::TimePoint, max_links + 1> asked_at_{};    // by group
};

}    // namespace anogate
