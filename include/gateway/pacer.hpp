// How many bytes may be written to a line now, so that the buffer of the driver is never more than `latency` ahead of the wire.
//
// Flow:    const auto next = outbox.next(now);
//          const std::size_t budget = pacer.allowance(next.size, next.urgent, now);    // 0: wait until pacer.next_at()
//          … gather within the budget, write n bytes …
//          pacer.sent(n, now);
//          pacer.correct(unsent, now);    // where the driver reports its unsent bytes
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>

namespace anogate {

/// Bytes/s of an asynchronous serial line: a start bit, eight data bits, parity, stop bits.
constexpr std::uint32_t uart_rate(std::uint32_t baud, bool parity, unsigned stop_bits) noexcept {
    return std::max(baud / (9u + (parity ? 1u : 0u) + stop_bits), 1u);
}

/// Stores the time when the line will have sent all written bytes. Used for a UART at its line rate and for any link with a
/// `rate`. Unused time is not saved: after a pause no burst is allowed.
class Pacer {
public:
    struct Options {
        std::uint32_t rate = 0;                                   // bytes/s; a UART with 8N1 sends baud / 10; 0: not known
        ano::Duration latency = std::chrono::milliseconds{20};    // up to 1 s
        ano::Duration gap{};    // frames are sent one by one, with a pause after each; zero: no pauses
    };
    /// Has a rate or a gap.
    explicit constexpr Pacer(const Options& options) noexcept : options_{options} {
        assert(options.rate > 0 || options.gap > ano::Duration::zero());
    }

    /// How many bytes may be written now: none, or at least `size` bytes, the size of the next frame. A whole frame may always be
    /// written to an idle line. A spent budget is renewed only when half of `latency` is free, so that a busy line needs few
    /// writes. An urgent frame does not wait for that.
    constexpr std::size_t allowance(std::size_t size, bool urgent, ano::TimePoint now) noexcept {
        const ano::Duration ahead = ahead_of(now);
        if (pauses()) return one_frame(size, now);
        if (spent_ && !urgent && ahead > options_.latency / 2) return 0;
        spent_ = false;
        const std::size_t room = bytes_in(options_.latency - ahead);
        if (ahead == ano::Duration::zero()) return std::max(size, room);
        if (size <= room) return room;
        spent_ = true;
        return 0;
    }
    /// When allowance() is above 0 for `size` bytes, if nothing is sent before.
    constexpr ano::TimePoint next_at(std::size_t size) const noexcept {
        if (done_at_ == ano::TimePoint::min()) return done_at_;    // nothing was sent yet
        if (pauses()) return done_at_ + options_.gap;
        const ano::Duration ahead = std::max(ano::Duration::zero(), options_.latency - time_of(size));
        return done_at_ - std::min(ahead, options_.latency / 2);
    }
    /// The driver accepted `bytes` at `now`.
    constexpr void sent(std::size_t bytes, ano::TimePoint now) noexcept {
        done_at_ = now + ahead_of(now) + time_of(bytes);
        left_ -= std::min(left_, bytes);
    }
    /// The driver still has `unsent` bytes at `now`: the line is slower than its rate, or stopped by flow control. If it has
    /// fewer than expected, nothing changes: there may be another buffer after it.
    constexpr void correct(std::size_t unsent, ano::TimePoint now) noexcept {
        done_at_ = std::max(now + ahead_of(now), now + time_of(unsent));
    }
    /// The wire is disconnected, and all unsent bytes are lost.
    constexpr void reset() noexcept {
        done_at_ = seen_ = ano::TimePoint::min();
        spent_ = false;
        left_ = 0;
    }

private:
    constexpr bool pauses() const noexcept { return options_.gap > ano::Duration::zero(); }
    // The whole next frame, or the rest of a partly sent one.
    constexpr std::size_t one_frame(std::size_t size, ano::TimePoint now) noexcept {
        if (left_ == 0 && done_at_ != ano::TimePoint::min() && now < done_at_ + options_.gap) return 0;
        return left_ = size;
    }
    // If the clock was set back, the time of the line is set back too.
    constexpr ano::Duration ahead_of(ano::TimePoint now) noexcept {
        if (now < seen_ && done_at_ > now) done_at_ -= std::min(seen_ - now, done_at_ - now);
        seen_ = now;
        return done_at_ > now ? done_at_ - now : ano::Duration::zero();
    }
    constexpr ano::Duration time_of(std::size_t bytes) const noexcept {
        return options_.rate > 0 ? ano::Duration{std::chrono::seconds{bytes}} / options_.rate : ano::Duration::zero();
    }
    constexpr std::size_t bytes_in(ano::Duration time) const noexcept {
        if (time <= ano::Duration::zero()) return 0;
        constexpr std::uint64_t second = ano::Duration{std::chrono::seconds{1}}.count();
        return static_cast<std::size_t>(static_cast<std::uint64_t>(time.count()) * options_.rate / second);
    }

    Options options_;
    ano::TimePoint done_at_ = ano::TimePoint::min();
    ano::TimePoint seen_ = ano::TimePoint::min();
    bool spent_ = false;
    std::size_t left_ = 0;    // with a gap: unsent bytes of the frame that is being sent
};

}    // namespace anogate
