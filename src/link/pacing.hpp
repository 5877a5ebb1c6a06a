// The pacer of a link, with the alarm that continues the sending.
#pragma once
#include <gateway/outbox.hpp>
#include <gateway/pacer.hpp>
#include <link/alarm.hpp>

#include <optional>

namespace anogate {

/// While it is off it never limits anything.
class Pacing {
public:
    /// `go_on` is called when more may be sent.
    Pacing(AlarmClock& clock, std::function<void()> go_on) : go_on_{clock, std::move(go_on)} {}

    /// Sends `rate` bytes/s, at most `latency` ahead of the wire. A rate of 0 turns pacing off.
    void start(std::uint32_t rate, ano::Duration latency) {
        stop();
        rate_ = rate;
        if (rate > 0) pacer_.emplace(Pacer::Options{rate, latency});
    }
    void stop() noexcept {
        pacer_.reset();
        go_on_.cancel();
        rate_ = 0;
    }

    /// How many bytes of `outbox` may be sent now. 0: none; `go_on` will be called.
    std::size_t budget(Outbox& outbox, ano::TimePoint now) {
        if (!pacer_) return SIZE_MAX;
        const Outbox::Next next = outbox.next(now);
        if (next.size == 0) return SIZE_MAX;
        const std::size_t budget = pacer_->allowance(next.size, next.urgent, now);
        if (budget == 0) {
            outbox.set_congested();
            go_on_.set(pacer_->next_at(next.size));
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
    /// Bytes/s; 0: not paced.
    std::uint32_t rate() const noexcept { return rate_; }

private:
    std::optional<Pacer> pacer_;
    Alarm go_on_;
    std::uint32_t rate_ = 0;
};

}    // namespace anogate
