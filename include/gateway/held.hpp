// Frames that wait for a judgement of the loop guard before they go on.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/ids.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace anogate {

/// A few short frames. Frames of one channel keep their order: none may be due before an earlier one. No allocation.
class Held {
public:
    static constexpr std::size_t max_frames = 32;
    static constexpr std::size_t max_frame_size = 64;    // bytes

    /// How many copies of a waiting frame its channel may bring, and until when; 0: no limit.
    struct Repeats {
        std::uint32_t max_count;
        ano::TimePoint until;
    };
    /// False: there is no room, or the frame is too long.
    bool put(ChannelId from, ano::FrameView frame, ano::TimePoint due, Repeats repeats = {},
             ano::TimePoint arrived_at = {}) noexcept {
        const auto bytes = frame.bytes();
        if (!fits(frame)) return false;
        Frame& held = frames_[count_++];
        held.from = from;
        held.due = due;
        held.repeats = repeats;
        held.arrived_at = arrived_at;
        held.size = bytes.size();
        std::copy(bytes.begin(), bytes.end(), held.bytes.begin());
        return true;
    }
    /// Whether put() has room for `frame`.
    bool fits(ano::FrameView frame) const noexcept { return count_ < max_frames && frame.bytes().size() <= max_frame_size; }
    /// Whether the channel brings more copies of `frame` than its `repeats` allow, so that it need not wait any longer.
    bool goes_on(ChannelId from, ano::FrameView frame, ano::TimePoint now) const noexcept {
        Repeats repeats{};
        std::uint32_t same = 0;
        for (const Frame& held : std::span{frames_}.first(count_)) {
            if (held.from != from || !std::ranges::equal(held.view().bytes(), frame.bytes())) continue;
            if (held.repeats.max_count > repeats.max_count) repeats = held.repeats;
            ++same;
        }
        return repeats.max_count > 0 && (same >= repeats.max_count || now > repeats.until);
    }
    /// When the last frame of a channel is due; std::nullopt when none waits.
    std::optional<ano::TimePoint> due(ChannelId from) const noexcept {
        std::optional<ano::TimePoint> last;
        for (const Frame& held : std::span{frames_}.first(count_))
            if (held.from == from) last = held.due;
        return last;
    }
    bool empty() const noexcept { return count_ == 0; }
    /// When the next frame is due; std::nullopt when none waits.
    std::optional<ano::TimePoint> due() const noexcept {
        std::optional<ano::TimePoint> next;
        for (const Frame& held : std::span{frames_}.first(count_)) next = std::min(next.value_or(held.due), held.due);
        return next;
    }

    struct Frame {
        ChannelId from{};
        ano::TimePoint due{};
        Repeats repeats{};
        ano::TimePoint arrived_at{};
        std::size_t size = 0;
        std::array<std::uint8_t, max_frame_size> bytes{};
        ano::FrameView view() const noexcept { return ano::FrameView{std::span{bytes}.first(size)}; }
    };
    /// Removes and returns the first frame that is due.
    std::optional<Frame> take(ano::TimePoint now) noexcept {
        return take_first([now](const Frame& held) { return held.due <= now; });
    }
    /// Removes and returns the first frame of the channel.
    std::optional<Frame> take(ChannelId from) noexcept {
        return take_first([from](const Frame& held) { return held.from == from; });
    }
    /// Drops the frames of a closed channel; returns how many there were.
    std::size_t forget(ChannelId from) noexcept {
        std::size_t forgotten = 0;
        while (take(from)) ++forgotten;
        return forgotten;
    }

private:
    template <class Which>
    std::optional<Frame> take_first(Which which) noexcept {
        const auto end = frames_.begin() + static_cast<std::ptrdiff_t>(count_);
        const auto first = std::find_if(frames_.begin(), end, which);
        if (first == end) return std::nullopt;
        const Frame frame = *first;
        std::move(first + 1, end, first);
        --count_;
        return frame;
    }

    std::array<Frame, max_frames> frames_{};
    std::size_t count_ = 0;
};

}    // namespace anogate
