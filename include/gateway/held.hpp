// Frames that wait for a verdict before they go on.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/ids.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace anogate {

/// A few short frames in the order in which they came. No allocation.
class Held {
public:
    static constexpr std::size_t most = 32, largest = 64;

    /// False: there is no room, or the frame is too long.
    bool put(ChannelId from, ano::FrameView frame, ano::TimePoint due, ano::TimePoint arrived_at = {}) noexcept {
        const auto bytes = frame.bytes();
        if (!fits(frame)) return false;
        Frame& held = frames_[(first_ + count_++) % most];
        held.from = from;
        held.due = due;
        held.arrived_at = arrived_at;
        held.size = bytes.size();
        std::copy(bytes.begin(), bytes.end(), held.bytes.begin());
        return true;
    }
    /// Whether there is room for it.
    bool fits(ano::FrameView frame) const noexcept { return count_ < most && frame.bytes().size() <= largest; }
    /// When the last of a channel is due; nothing when none waits.
    std::optional<ano::TimePoint> due(ChannelId from) const noexcept {
        std::optional<ano::TimePoint> last;
        for (std::size_t i = 0; i < count_; ++i)
            if (const Frame& frame = frames_[(first_ + i) % most]; frame.from == from) last = frame.due;
        return last;
    }
    bool empty() const noexcept { return count_ == 0; }
    /// When the first is due; nothing when none waits.
    std::optional<ano::TimePoint> due() const noexcept {
        return count_ == 0 ? std::nullopt : std::optional{frames_[first_].due};
    }

    struct Frame {
        ChannelId from{};
        ano::TimePoint due{};
        ano::TimePoint arrived_at{};
        std::size_t size = 0;
        std::array<std::uint8_t, largest> bytes{};
        ano::FrameView view() const noexcept { return ano::FrameView{std::span{bytes}.first(size)}; }
    };
    /// The first, when it is due.
    std::optional<Frame> take(ano::TimePoint now) noexcept {
        if (count_ == 0 || frames_[first_].due > now) return std::nullopt;
        const Frame& frame = frames_[first_];
        first_ = (first_ + 1) % most;
        --count_;
        return frame;
    }
    /// Forgets those of a channel that is no more; how many there were.
    std::size_t forget(ChannelId from) noexcept {
        std::size_t kept = 0;
        const std::size_t before = count_;
        for (std::size_t i = 0; i < before; ++i) {
            const Frame& frame = frames_[(first_ + i) % most];
            if (frame.from != from) frames_[(first_ + kept++) % most] = frame;
        }
        count_ = kept;
        return before - kept;
    }

private:
    std::array<Frame, most> frames_{};
    std::size_t first_ = 0, count_ = 0;
};

}  // namespace anogate
