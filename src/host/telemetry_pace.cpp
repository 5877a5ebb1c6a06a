#include <host/telemetry_pace.hpp>

#include <algorithm>

namespace ano::host {

Duration TelemetryPace::longest_pause() const noexcept { return longest_pause_at(usual_); }

// At a slow pace, two missed frames count as a pause: one is often lost, and a command would wait for a question.
Duration TelemetryPace::longest_pause_at(Duration usual) noexcept {
    return std::max(max_pause, std::min(usual_intervals * usual, 2 * usual + usual / 2 + max_late));
}

bool TelemetryPace::came(TimePoint now, std::optional<TimePoint> heard_at) noexcept {
    const bool was_known = is_known();
    bool has_paused = was_known && pauses(now);
    if (const auto since = last_ ? last_ : heard_at; since && !was_known) unjudged_ = std::max(unjudged_, now - *since);
    count(now);
    if (!was_known && intervals_ > 0 && unjudged_ > longest_pause()) {
        has_paused = true;
        unjudged_ = {};
    }
    last_ = now;
    return has_paused;
}

// Uses the shorter one of the first two intervals: the other may be a pause.
void TelemetryPace::count(TimePoint now) noexcept {
    if (!last_) begun_ = now;
    const Duration interval = now - begun_;
    if (interval < together) return;
    begun_ = now;
    if (intervals_ == 0) usual_ = interval;
    else usual_ = is_known() ? (7 * usual_ + interval) / 8 : std::min(usual_, interval);
    intervals_ = std::min(intervals_ + 1, 2);
}

// Until the first interval is over, it is the only measure of the pace. It may be a pause itself: then the pause is detected
// later.
bool TelemetryPace::pauses(TimePoint now) const noexcept {
    if (!last_) return false;
    if (intervals_ > 0) return now - *last_ > longest_pause();
    return unjudged_ > std::max(max_pause, usual_intervals * (now - *last_));
}

}    // namespace ano::host
