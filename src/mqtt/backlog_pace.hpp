// When the next batch of the spool may be published: a batch at a time, for at most a quarter of the time, so that live records find the
// connection free. No I/O, no clock.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace anogate {

class BacklogPace {
public:
    /// `rate`: the most bytes per second.
    explicit BacklogPace(std::uint64_t rate) : rate_{rate} {}

    ano::TimePoint next() const noexcept { return next_; }
    bool may_publish(ano::TimePoint now) const noexcept { return now >= next_; }
    void on_published(std::size_t bytes, ano::TimePoint now) noexcept {
        begun_ = now;
        const auto seconds = std::chrono::duration<double>{static_cast<double>(bytes) / static_cast<double>(rate_)};
        next_ = now + std::chrono::duration_cast<ano::Duration>(seconds);
    }
    /// The time until the broker acknowledged a batch is what a batch of this size takes on this connection.
    void on_acknowledged(ano::TimePoint now) noexcept { next_ = std::max(next_, now + pauses * (now - begun_)); }
    /// The broker can't accept more now, or the spool is empty.
    void wait(ano::TimePoint until) noexcept { next_ = std::max(next_, until); }

private:
    static constexpr int pauses = 3;    // for one batch

    std::uint64_t rate_;
    ano::TimePoint begun_{}, next_{};
};

}    // namespace anogate
