// How long the data of a TCP connection has waited for an acknowledgement.
#pragma once
#include <ano/time.hpp>
#include <link/tcp/in_flight_limit.hpp>

#include <chrono>
#include <cstddef>

namespace anogate {

/// Flow:    see(bytes, now) → wrote(count) → see(...)...
class UnacknowledgedData {
public:
    /// `bytes`: not acknowledged now.
    void see(std::size_t bytes, ano::TimePoint now) noexcept {
        if (bytes < bytes_ || bytes_ == 0) {
            since_ = now;
            writes_ = 0;
        }
        bytes_ = bytes;
    }
    /// After see(), at the same time.
    void wrote(std::size_t count, ano::TimePoint now) noexcept {
        bytes_ += count;
        if (++writes_ == 2) second_at_ = now;
    }

    std::size_t bytes() const noexcept { return bytes_; }
    /// The time without any acknowledgement although data waits for one; zero: none waits.
    ano::Duration age(ano::TimePoint now) const noexcept { return bytes_ == 0 ? ano::Duration{} : now - since_; }
    /// Whether that is much longer than the path needs: the connection is probably interrupted. `measure` returns the RoundTrip;
    /// it is called only if needed.
    template <typename Measure>
    bool is_late(ano::TimePoint now, Measure measure) const {
        return is_beyond(InFlightLimit::late_acknowledgement, age(now), measure);
    }
    /// Whether nothing more should be written for now: as is_late(), or two writes wait, and the second does for longer than the
    /// path needs. The other end may delay the acknowledgement of one write, but not that of two.
    template <typename Measure>
    bool may_be_interrupted(ano::TimePoint now, Measure measure) const {
        return is_late(now, measure) || (bytes_ > 0 && writes_ >= 2 && is_beyond(late_for_two, now - second_at_, measure));
    }

private:
    static constexpr ano::Duration late_for_two = std::chrono::milliseconds{100};    // Linux delays up to 40 ms

    template <typename Measure>
    static bool is_beyond(ano::Duration delay, ano::Duration waits, Measure measure) {
        return waits > delay && waits > delay + 2 * measure().now;
    }

    std::size_t bytes_ = 0;
    std::size_t writes_ = 0;    // since the last acknowledgement
    ano::TimePoint since_{}, second_at_{};
};

}    // namespace anogate
