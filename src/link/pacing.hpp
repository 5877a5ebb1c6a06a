// The pacer of a link, with the alarm that continues the sending.
#pragma once
#include <gateway/outbox.hpp>
#include <gateway/pacer.hpp>
#include <sys/alarm.hpp>

#include <optional>

namespace anogate {

/// Limits the rate of sending. While pacing is off, nothing is limited.
class Pacing {
public:
    /// `go_on` is called when more may be sent.
    Pacing(AlarmClock& clock, std::function<void()> go_on) : go_on_{clock, std::move(go_on)} {}

    /// Allows `rate` bytes/s, at most `latency` ahead of the wire; with a `gap` one frame at a time, each followed by a pause.
    /// Without rate and gap, pacing is off.
    void start(std::uint32_t rate, ano::Duration latency, ano::Duration gap = {}) {
        stop();
        rate_ = rate;
        pauses_ = gap > ano::Duration::zero();
        if (rate > 0 || gap > ano::Duration::zero()) pacer_.emplace(Pacer::Options{rate, latency, gap});
    }
    void stop() noexcept {
        pacer_.reset();
        go_on_.cancel();
        rate_ = 0;
        pauses_ = false;
    }

    /// The number of bytes of `outbox` that may be sent now. 0: none; `go_on` will be called.
    std::size_t budget(Outbox& outbox, ano::TimePoint now) {
        if (!pacer_) return SIZE_MAX;
        const Outbox::Next next = outbox.next(now);
        if (next.size == 0) return SIZE_MAX;
        const std::size_t least = next.is_zeros && !pauses_ ? 1 : next.size;
        const std::size_t budget = pacer_->allowance(least, next.urgent, now);
        if (budget == 0) {
            outbox.set_congested();
            go_on_.set(pacer_->next_at(least));
        }
        return budget;
    }
    void sent(std::size_t bytes, ano::TimePoint now) noexcept {
        if (pacer_) pacer_->sent(bytes, now);
    }
    /// To be called when the driver reports that it still holds `unsent` bytes.
    void correct(std::size_t unsent, ano::TimePoint now) noexcept {
        if (pacer_) pacer_->correct(unsent, now);
    }
    bool is_on() const noexcept { return pacer_.has_value(); }
    /// Whether a pause follows each frame; sent() then needs the time after the write.
    bool pauses() const noexcept { return pauses_; }
    /// Bytes/s; 0: not limited.
    std::uint32_t rate() const noexcept { return rate_; }

private:
    std::optional<Pacer> pacer_;
    Alarm go_on_;
    std::uint32_t rate_ = 0;
    bool pauses_ = false;
};

}    // namespace anogate
