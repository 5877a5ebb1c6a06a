// Limits the bytes in flight on a TCP connection, so that an urgent frame does not wait long behind them.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace anogate {

/// Bytes that TCP sends faster than the slowest line of the path can carry queue up before that line, where no frame can pass
/// another. So about as much is in flight as queues for `most_waiting` there, or for one round trip if that is longer. While this
/// limits sending, the bytes in flight drain to `nearly_none` once per minute: only then can the kernel measure the round trip of
/// a path without a queue.
class InFlightLimit {
public:
    static constexpr std::size_t least = 6 * 1024;    // always allowed: 25 ms at 2 Mbit/s
    static constexpr std::size_t most = 64 * 1024;    // the send buffer
    static constexpr ano::Duration most_waiting = std::chrono::milliseconds{20};
    static constexpr std::size_t nearly_none = 2 * 1024;
    static constexpr ano::Duration between_drains = std::chrono::minutes{1};
    static constexpr ano::Duration between_probes = std::chrono::seconds{15};
    /// An acknowledgement may be this late without a longer path.
    static constexpr ano::Duration late_acknowledgement = std::chrono::milliseconds{280};

    /// As measured by the kernel: smoothed, and the shortest of the last minutes.
    struct RoundTrip {
        ano::Duration now{}, shortest{};
    };

    /// Zero: more may be sent while `in_flight` bytes are not acknowledged. Otherwise call again after the returned time.
    /// `measure` returns the RoundTrip; it is called only if needed.
    template <typename Measure>
    ano::Duration wait(std::size_t in_flight, ano::TimePoint now, Measure measure) {
        if (in_flight == 0) probed(now);
        if (in_flight <= nearly_none) {
            drained_at_ = now;
            was_limited_ = was_limited_ && probe_ != Probe::none;
        }
        const bool drains = was_limited_ && now - drained_at_ > between_drains;
        if (in_flight == 0 || (in_flight <= least && probe_ == Probe::none && !drains)) return {};
        const RoundTrip trip = measure();
        adapt(in_flight, trip, now);
        const std::size_t goal = probe_ != Probe::none ? 0 : drains ? nearly_none : limit_;
        if (in_flight <= goal) return {};
        was_limited_ = true;
        const auto excess = static_cast<double>(in_flight - goal) / static_cast<double>(in_flight);
        const auto time = std::chrono::duration_cast<ano::Duration>(trip.now * excess);
        return std::clamp<ano::Duration>(time, std::chrono::milliseconds{1}, std::chrono::milliseconds{100});
    }

    std::size_t limit() const noexcept { return limit_; }

private:
    // First all bytes in flight must be acknowledged (`empties`), then the next write (`measures`): its time is the round trip of
    // the path.
    enum class Probe : std::uint8_t { none, empties, measures };

    void probed(ano::TimePoint now) noexcept {
        if (probe_ == Probe::measures) way_ = now - began_;
        probe_ = probe_ == Probe::empties ? Probe::measures : Probe::none;
        began_ = probed_at_ = now;
    }
    // The kernel's shortest round trip may be five minutes old, and the path may be longer now.
    ano::Duration when_nothing_waits(const RoundTrip& trip) const noexcept {
        return way_ > 2 * trip.shortest + late_acknowledgement ? way_ : trip.shortest;
    }
    void look_for_longer_way(const RoundTrip& trip, ano::TimePoint now) noexcept {
        const bool seems_longer = limit_ == least && trip.now > 2 * trip.shortest + late_acknowledgement;
        if (seems_longer && probe_ == Probe::none && now - probed_at_ > between_probes) probe_ = Probe::empties;
    }
    // Moves the limit towards the longest permitted round trip, and waits until the last change is visible in it.
    void adapt(std::size_t in_flight, const RoundTrip& trip, ano::TimePoint now) noexcept {
        const ano::Duration visible_after = std::max(trip.now, 3 * most_waiting);
        if (trip.now <= ano::Duration::zero() || in_flight < limit_ / 2 || now - adapted_at_ < visible_after) return;
        const ano::Duration base = when_nothing_waits(trip);
        const ano::Duration aim = std::max(2 * base, base + most_waiting);
        const double factor = std::clamp(static_cast<double>(aim.count()) / static_cast<double>(trip.now.count()), 0.5, 1.25);
        limit_ = std::clamp(static_cast<std::size_t>(static_cast<double>(limit_) * factor), least, most);
        adapted_at_ = now;
        look_for_longer_way(trip, now);
    }

    std::size_t limit_ = least;
    bool was_limited_ = false;    // since the last drain
    Probe probe_ = Probe::none;
    ano::Duration way_{};
    ano::TimePoint adapted_at_{}, drained_at_{}, probed_at_{}, began_{};
};

}    // namespace anogate
