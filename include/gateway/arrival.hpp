// The arrival time of the data that a link reads. The age of a frame counts from there, even if the loop could not read for a
// while.
//
// Flow:    loop.turn(clocks)                                   // whenever something is read, and at each beat
//          channel.arrived_at = arrival.stamped(stamp, loop)   // or unstamped(loop)
//          arrival.found_empty(loop.before())                  // nothing more waits, and the previous turn was before the read
//          loop.beat(period)                                   // at least once in a `period`, after turn()
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <cstdint>
#include <optional>

namespace anogate {

/// The clocks, read together.
struct ClockReading {
    ano::TimePoint now{};    // CLOCK_MONOTONIC
    ano::Duration boot{};    // CLOCK_BOOTTIME, which also counts while the machine is suspended
    ano::Duration real{};    // CLOCK_REALTIME, which may be set at any time
};

/// Detects standstills of the event loop: a running loop sends a beat once in each period. Nothing is known of the time between
/// two beats, so a standstill may have begun as early as the last turn before it.
class StallDetector {
public:
    /// A beat that is late by more than this shows a standstill. Smaller delays are normal on a busy machine.
    static constexpr ano::Duration lateness = std::chrono::milliseconds{50};
    /// A standstill longer than this is reported.
    static constexpr ano::Duration min_reported = std::chrono::milliseconds{500};
    /// A standstill may have begun up to this long before the late beat was due. That time is added before the comparison with
    /// `min_reported`.
    static constexpr ano::Duration unseen = std::chrono::milliseconds{120};
    /// Data that waited through a standstill is read within this time after it.
    static constexpr ano::Duration catching_up = std::chrono::milliseconds{100};

    struct Turn {
        ano::Duration stood{};        // minimum duration of the standstill before this turn; zero: none
        ano::Duration suspended{};    // the part of the time since the previous turn that the clock of TimePoint does not count
        bool is_reported = false;
    };
    Turn turn(const ClockReading& clocks) noexcept {
        const ClockReading before = before_ = clocks_;
        clocks_ = clocks;
        if (!beats_) return {};
        if (clocks.now - before.now > min_reported) gap_ = {before.now, clocks.now};
        const ano::Duration asleep = (clocks.boot - before.boot) - (clocks.now - before.now);
        const ano::Duration suspended = asleep > lateness ? asleep : ano::Duration{};    // below that: the clocks were read one
                                                                                         // after the other
        const ano::Duration late = std::max(clocks.now - due_ + suspended, suspended);
        if (late <= lateness) return {};
        stood_since_ = before.boot;
        stood_until_ = clocks.now;
        due_ = clocks.now + period_;
        is_over_ = false;
        const bool is_reported = late + std::min(period_, unseen) > min_reported;
        if (is_reported) count(late);
        return {late, suspended, is_reported};
    }
    /// Data arrived at `arrived`, by its stamp. It may have waited through a standstill in which no beat was due. Returns the
    /// duration of the standstill if it must be reported; zero: it is too short, or was already reported.
    ano::Duration waited(ano::TimePoint arrived) noexcept {
        const ano::Duration stood = gap_.until - std::max(arrived, gap_.since);
        if (stood <= min_reported) return {};
        count(stood);
        return stood;
    }
    /// The next beat is `period` from the last turn().
    void beat(ano::Duration period) noexcept {
        beats_ = true;
        period_ = period;
        due_ = clocks_.now + period;
    }
    /// Call when everything that was readable at the end of the standstill has been read once.
    void end_standstill() noexcept { is_over_ = true; }

    const ClockReading& clocks() const noexcept { return clocks_; }
    /// The clocks at the turn before the last.
    const ClockReading& before() const noexcept { return before_; }
    ano::TimePoint now() const noexcept { return clocks_.now; }
    /// After a standstill: some wires have not been read since.
    bool is_behind() const noexcept { return !is_over_; }
    ano::Duration stood_since() const noexcept { return stood_since_; }    // by CLOCK_BOOTTIME
    ano::TimePoint stood_until() const noexcept { return stood_until_; }

    /// How many standstills were reported, and the duration of the longest.
    std::uint64_t standstills() const noexcept { return standstills_; }
    ano::Duration longest() const noexcept { return longest_; }
    /// When the last reported standstill ended.
    ano::TimePoint last_standstill() const noexcept { return last_standstill_; }
    /// Whether data without a stamp that was read at `time` may have waited through the last reported standstill.
    bool may_have_waited(ano::TimePoint time) const noexcept { return standstills_ > 0 && time < last_standstill_ + catching_up; }

private:
    // The time between two turns.
    struct Gap {
        ano::TimePoint since{}, until{};
    };
    void count(ano::Duration stood) noexcept {
        gap_ = {};
        ++standstills_;
        last_standstill_ = clocks_.now;
        longest_ = std::max(longest_, stood);
    }

    ClockReading clocks_{};    // of the last turn
    ClockReading before_{};    // of the turn before
    Gap gap_{};                // the last gap that was longer than `min_reported` and is not counted
    ano::Duration period_{};
    ano::TimePoint due_{};    // the next beat
    ano::Duration stood_since_{};
    ano::TimePoint stood_until_ = ano::TimePoint::min();
    ano::TimePoint last_standstill_ = ano::TimePoint::min();
    ano::Duration longest_{};
    std::uint64_t standstills_ = 0;
    bool beats_ = false;
    bool is_over_ = true;
};

/// The arrival times on one wire. To be used in the turn in which the data was read.
class Arrival {
public:
    /// The arrival time by the kernel's stamp, a CLOCK_REALTIME. It is limited to the time between the last read that found the
    /// wire empty and now. If that clock was set in between, the stamp is not used.
    ano::TimePoint stamped(ano::Duration stamp, const StallDetector& loop) noexcept {
        const ClockReading& c = loop.clocks();
        const ano::Duration step = (c.real - c.boot) - (empty_.real - empty_.boot);
        if (step > noticed || step < -noticed) return unstamped(loop);
        return c.now - std::clamp(c.real - stamp, ano::Duration::zero(), std::max(c.boot - empty_.boot, ano::Duration::zero()));
    }
    /// The arrival time without a stamp: now, or after a standstill the earliest time at which the standstill may have begun.
    ano::TimePoint unstamped(const StallDetector& loop) noexcept {
        const ClockReading& c = loop.clocks();
        if (loop.is_behind() && empty_.now < loop.stood_until() && !old_since_)
            old_since_ = std::max(loop.stood_since(), empty_.boot);
        return old_since_ ? c.now - (c.boot - *old_since_) : c.now;
    }
    /// A read found the wire empty. `before`: the clocks as read before it, since the loop may stand still between the read and a
    /// later reading of the clocks.
    void found_empty(const ClockReading& before) noexcept {
        empty_ = before;
        old_since_.reset();
    }
    /// The wire was not read since `then`, so its data may have arrived at any time since.
    void unread_since(const ClockReading& then) noexcept {
        empty_ = then;
        old_since_ = then.boot;
    }
    /// The data left on the wire may have arrived during the standstill. Ends when the wire is found empty.
    bool is_behind() const noexcept { return old_since_.has_value(); }

private:
    static constexpr ano::Duration noticed = std::chrono::milliseconds{50};    // less is within the accepted error of an age

    ClockReading empty_{};
    std::optional<ano::Duration> old_since_;    // by CLOCK_BOOTTIME
};

}    // namespace anogate
