// A periodic alarm that detects standstills of the loop.
#pragma once
#include <gateway/arrival.hpp>
#include <runtime/standstill_log.hpp>
#include <sys/alarm.hpp>

#include <functional>

namespace anogate {

/// Flow:    beat.begin(); beat.turn(clocks); beat.end(…)    // in `call`, and once at the start
///          beat.turn(clocks)                                // whenever something was read
///          beat.heard(…)                                    // for every frame
class StallWatch {
public:
    StallWatch(AlarmClock& alarms, std::function<void()> call);

    /// Returns how long the machine was suspended since the last turn: all waiting data is older by that time.
    ano::Duration turn(const ClockReading& clocks);
    /// Begins the processing of a beat.
    void begin() noexcept { noticed_ = false; }
    /// `streams_are_active`: bytes are being received from serial ports or ptys, which have no time stamps.
    void end(bool streams_are_active);
    /// Data was received, from a stream or a datagram socket; `arrived_at` is its time of arrival.
    void heard(bool by_stream, ano::TimePoint arrived_at);

    void cancel() noexcept { alarm_.cancel(); }
    /// To be called at the end of the program: logs the rest.
    void finish();

    const StallDetector& loop() const noexcept { return loop_; }
    /// When no stream sends for this long, the beats become slow, to save CPU time.
    static constexpr ano::Duration calm_after = std::chrono::seconds{2};

private:
    StallDetector loop_;
    StandstillLog log_;
    Alarm alarm_;
    bool noticed_ = false;    // a standstill was detected since the beat was due
    bool calm_ = true;        // no stream sent for calm_after: the beat is slow
};

}    // namespace anogate
