// The beats that tell whether the loop stood still.
#pragma once
#include <daemon/standstill_log.hpp>
#include <gateway/arrival.hpp>
#include <link/alarm.hpp>

#include <functional>

namespace anogate {

/// Flow:    beat.begin(); beat.turn(clocks); beat.end(…)    // where it is called, and once at the start
///          beat.turn(clocks)                                // whenever something was read
///          beat.heard(…)                                    // for every frame
class LoopBeat {
public:
    LoopBeat(AlarmClock& alarms, std::function<void()> call);

    /// What the machine slept of the time since the turn before: all that waits is that much older.
    ano::Duration turn(const ClockReading& clocks);
    /// A beat.
    void begin() noexcept { noticed_ = false; }
    /// `streams_speak`: serial ports or ptys bring bytes, which bear no stamp.
    void end(bool streams_speak);
    /// Something came by a stream or not, and had arrived then.
    void heard(bool by_stream, ano::TimePoint arrived_at);

    void cancel() noexcept { alarm_.cancel(); }
    /// Nothing more will be told.
    void finish();

    const LoopWatch& loop() const noexcept { return loop_; }
    /// Who sends nothing for so long is to cost nothing: the beats become slow.
    static constexpr ano::Duration calm_after = std::chrono::seconds{2};

private:
    LoopWatch loop_;
    StandstillLog log_;
    Alarm alarm_;
    bool noticed_ = false;    // a standstill, since the beat was due
    bool calm_ = true;        // no stream spoke lately: the beat is slow
};

}    // namespace anogate
