// How often a device sends telemetry, and whether its telemetry pauses.
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <optional>

namespace ano::host {

/// A pause is longer than max_pause and three usual intervals; at a slow pace, longer than two and a half intervals and max_late.
/// Frames within `together` count as one, since many devices send several at a time. While the pace is not known, nothing counts
/// as a pause: it is judged again when a second interval shows the pace.
class TelemetryPace {
public:
    static constexpr Duration max_pause = std::chrono::milliseconds{500};
    static constexpr int usual_intervals = 3;
    static constexpr Duration max_late = std::chrono::milliseconds{300};
    static constexpr Duration together = max_pause / usual_intervals;

    /// A frame of telemetry was received; `heard_at`: the time of the last frame of any kind before it. True: there was a pause
    /// before this frame, or, as the pace now shows, before an earlier one.
    bool came(TimePoint now, std::optional<TimePoint> heard_at) noexcept;
    bool pauses(TimePoint now) const noexcept;
    /// A longer one is a pause.
    Duration longest_pause() const noexcept;

private:
    static Duration longest_pause_at(Duration usual) noexcept;
    bool is_known() const noexcept { return intervals_ >= 2; }
    void count(TimePoint now) noexcept;

    std::optional<TimePoint> last_;
    TimePoint begun_{};    // of the frames that count as one
    Duration usual_{};     // interval between these
    int intervals_ = 0;
    Duration unjudged_{};    // the longest interval while the pace was not known
};

}    // namespace ano::host
