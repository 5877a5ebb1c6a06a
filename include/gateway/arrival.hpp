// When what a link reads had arrived. The age of a frame counts from there, however long the loop could not read.
//
// Flow:    loop.turn(clocks)                                   // whenever something is read, and at each beat
//          channel.arrived_at = arrival.stamped(stamp, loop)   // or unstamped(loop)
//          arrival.found_empty(loop.before())                  // nothing more waits, and the turn before was ahead of the read
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
    ano::Duration boot{};    // CLOCK_BOOTTIME, which runs on while the machine is suspended
    ano::Duration real{};    // CLOCK_REALTIME, which may be set at any time
};

/// Knows whether the loop ran all the time, by beats that it does not let go by while it does. Between two beats nothing shows
/// that it runs: a standstill may have begun as early as the last sign of life before it.
class LoopWatch {
public:
    /// Beats later than this are late; below it, the machine is busy.
    static constexpr ano::Duration lateness = std::chrono::milliseconds{50};
    /// A standstill longer than this is told,
    static constexpr ano::Duration told = std::chrono::milliseconds{500};
    /// and a shorter one that may have begun so long before the beat was due.
    static constexpr ano::Duration unseen = std::chrono::milliseconds{120};
    /// What waited through a standstill is read within this time behind it.
    static constexpr ano::Duration catching_up = std::chrono::milliseconds{100};

    struct Turn {
        ano::Duration stood{};        // how long it stood still before this turn, at least; zero: not at all
        ano::Duration suspended{};    // of the time since the turn before, what the clock of TimePoint does not count
        bool is_told = false;
    };
    Turn turn(const ClockReading& clocks) noexcept {
        const ClockReading before = before_ = clocks_;
        clocks_ = clocks;
        if (!beats_) return {};
        if (clocks.now - before.now > told) gap_ = {before.now, clocks.now};
        const ano::Duration asleep = (clocks.boot - before.boot) - (clocks.now - before.now);
        const ano::Duration suspended = asleep > lateness ? asleep
                                                          : ano::Duration{};    // below it, the clocks were not read at once
        const ano::Duration late = std::max(clocks.now - due_ + suspended, suspended);
        if (late <= lateness) return {};
        stood_since_ = before.boot;
        stood_until_ = clocks.now;
        due_ = clocks.now + period_;
        is_over_ = false;
        const bool is_told = late + std::min(period_, unseen) > told;
        if (is_told) count(late);
        return {late, suspended, is_told};
    }
    /// Something that was to be read arrived at `arrived`, by its stamp. It may have been waiting for all of a standstill that no
    /// beat was due in. How long that was, when it is to be told; zero: it is not, or was already.
    ano::Duration waited(ano::TimePoint arrived) noexcept {
        const ano::Duration stood = gap_.until - std::max(arrived, gap_.since);
        if (stood <= told) return {};
        count(stood);
        return stood;
    }
    /// The next beat is `period` from the last turn().
    void beat(ano::Duration period) noexcept {
        beats_ = true;
        period_ = period;
        due_ = clocks_.now + period;
    }
    /// What was readable when the standstill was noticed has been read once.
    void end_standstill() noexcept { is_over_ = true; }

    const ClockReading& clocks() const noexcept { return clocks_; }
    /// Of the turn before the last.
    const ClockReading& before() const noexcept { return before_; }
    ano::TimePoint now() const noexcept { return clocks_.now; }
    /// It stood still, and there are wires that nobody has looked at since.
    bool is_behind() const noexcept { return !is_over_; }
    ano::Duration stood_since() const noexcept { return stood_since_; }    // by CLOCK_BOOTTIME
    ano::TimePoint stood_until() const noexcept { return stood_until_; }

    /// How often it stood still for longer than `told`, and the longest.
    std::uint64_t standstills() const noexcept { return standstills_; }
    ano::Duration longest() const noexcept { return longest_; }
    /// When the last of those ended.
    ano::TimePoint last_standstill() const noexcept { return told_until_; }
    /// What was read at `time`, and bears no stamp, may have been waiting through the last of those.
    bool may_have_waited(ano::TimePoint time) const noexcept { return standstills_ > 0 && time < told_until_ + catching_up; }

private:
    // Between two turns.
    struct Gap {
        ano::TimePoint since{}, until{};
    };
    void count(ano::Duration stood) noexcept {
        gap_ = {};
        ++standstills_;
        told_until_ = clocks_.now;
        longest_ = std::max(longest_, stood);
    }

    ClockReading clocks_{};    // of the last turn
    ClockReading before_{};    // of the one before
    Gap gap_{};                // the last that was longer than `told` and is not counted
    ano::Duration period_{};
    ano::TimePoint due_{};    // the next beat
    ano::Duration stood_since_{};
    ano::TimePoint stood_until_ = ano::TimePoint::min();
    ano::TimePoint told_until_ = ano::TimePoint::min();
    ano::Duration longest_{};
    std::uint64_t standstills_ = 0;
    bool beats_ = false;
    bool is_over_ = true;
};

/// Of one wire. Whether it is as old as a standstill is asked at the turn in which it was read.
class Arrival {
public:
    /// By the kernel's stamp, a CLOCK_REALTIME. Neither younger than now nor older than the time since the wire was found
    /// empty; where that clock was set in between, the stamp says nothing.
    ano::TimePoint stamped(ano::Duration stamp, const LoopWatch& loop) noexcept {
        const ClockReading& c = loop.clocks();
        const ano::Duration step = (c.real - c.boot) - (empty_.real - empty_.boot);
        if (step > noticed || step < -noticed) return unstamped(loop);
        return c.now - std::clamp(c.real - stamp, ano::Duration::zero(), std::max(c.boot - empty_.boot, ano::Duration::zero()));
    }
    /// Without one. Now; behind a standstill, when that may have begun.
    ano::TimePoint unstamped(const LoopWatch& loop) noexcept {
        const ClockReading& c = loop.clocks();
        if (loop.is_behind() && empty_.now < loop.stood_until() && !old_since_)
            old_since_ = std::max(loop.stood_since(), empty_.boot);
        return old_since_ ? c.now - (c.boot - *old_since_) : c.now;
    }
    /// Nothing more waits on the wire: a read found that, and the clocks were read `before` it. Behind the read the loop may stand
    /// still before it can read them.
    void found_empty(const ClockReading& before) noexcept {
        empty_ = before;
        old_since_.reset();
    }
    /// What waits on the wire may have come at any time since: nobody has read it.
    void unread_since(const ClockReading& then) noexcept {
        empty_ = then;
        old_since_ = then.boot;
    }
    /// What is left on the wire is as old as the standstill: read until it is found empty.
    bool is_behind() const noexcept { return old_since_.has_value(); }

private:
    static constexpr ano::Duration noticed = std::chrono::milliseconds{50};    // less is within what an age may be wrong

    ClockReading empty_{};
    std::optional<ano::Duration> old_since_;    // by CLOCK_BOOTTIME
};

}    // namespace anogate
