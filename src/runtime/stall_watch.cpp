#include <runtime/stall_watch.hpp>

#include <utility>

namespace anogate {
namespace {

constexpr ano::Duration beat_of_streams = std::chrono::milliseconds{100};    // half the age limit of stick frames
constexpr ano::Duration calm_beat = std::chrono::milliseconds{500};
constexpr ano::Duration slack = std::chrono::milliseconds{20};

}    // namespace

StallWatch::StallWatch(AlarmClock& alarms, std::function<void()> call) : alarm_{alarms, std::move(call), slack} {}

ano::Duration StallWatch::turn(const ClockReading& clocks) {
    const StallDetector::Turn turn = loop_.turn(clocks);
    if (turn.stood == ano::Duration::zero()) return {};
    noticed_ = true;
    if (alarm_.is_set()) alarm_.set_no_later(loop_.now() + beat_of_streams);
    log_.stood(turn, loop_.now());
    return turn.suspended;
}

// A standstill ends with the first beat after it, because all waiting data was read by then; the beat that detected the
// standstill does not count.
void StallWatch::end(bool streams_are_active) {
    if (!noticed_) loop_.end_standstill();
    calm_ = !noticed_ && !streams_are_active;
    const ano::Duration period = calm_ ? calm_beat : beat_of_streams;
    loop_.beat(period + slack);
    alarm_.set(loop_.now() + period);
}

// A stream switches to the faster beats. The time stamp of a received datagram also reveals a standstill.
void StallWatch::heard(bool by_stream, ano::TimePoint arrived_at) {
    if (by_stream) {
        if (!calm_) return;
        calm_ = false;
        loop_.beat(beat_of_streams + slack);
        alarm_.set_no_later(loop_.now() + beat_of_streams);
    } else if (const ano::Duration stood = loop_.waited(arrived_at); stood > ano::Duration::zero()) {
        log_.stood({.stood = stood, .is_reported = true}, loop_.now());
    }
}

void StallWatch::finish() {
    alarm_.cancel();
    log_.finish();
}

}    // namespace anogate
