#include <runtime/loop_beat.hpp>

#include <utility>

namespace anogate {
namespace {

constexpr ano::Duration beat_of_streams = std::chrono::milliseconds{100};    // bytes have no stamp: half the wait of stick frames
constexpr ano::Duration calm_beat = std::chrono::milliseconds{500};
constexpr ano::Duration slack = std::chrono::milliseconds{20};

}    // namespace

LoopBeat::LoopBeat(AlarmClock& alarms, std::function<void()> call) : alarm_{alarms, std::move(call), slack} {}

ano::Duration LoopBeat::turn(const ClockReading& clocks) {
    const LoopWatch::Turn turn = loop_.turn(clocks);
    if (turn.stood == ano::Duration::zero()) return {};
    noticed_ = true;
    if (alarm_.is_set()) alarm_.set_no_later(loop_.now() + beat_of_streams);
    log_.stood(turn, loop_.now());
    return turn.suspended;
}

// After a standstill, a beat is called when everything that waited was read; but not if that beat itself detected the standstill.
void LoopBeat::end(bool streams_speak) {
    if (!noticed_) loop_.end_standstill();
    calm_ = !noticed_ && !streams_speak;
    const ano::Duration period = calm_ ? calm_beat : beat_of_streams;
    loop_.beat(period + slack);
    alarm_.set(loop_.now() + period);
}

// Between slow beats: a stream needs faster beats; a time stamp of a received datagram shows a standstill too.
void LoopBeat::heard(bool by_stream, ano::TimePoint arrived_at) {
    if (by_stream) {
        if (!calm_) return;
        calm_ = false;
        loop_.beat(beat_of_streams + slack);
        alarm_.set_no_later(loop_.now() + beat_of_streams);
    } else if (const ano::Duration stood = loop_.waited(arrived_at); stood > ano::Duration::zero()) {
        log_.stood({.stood = stood, .is_told = true}, loop_.now());
    }
}

void LoopBeat::finish() {
    alarm_.cancel();
    log_.finish();
}

}    // namespace anogate
