// How long the data of a TCP connection has waited for an acknowledgement.
#pragma once
#include <ano/time.hpp>
#include <link/tcp/in_flight_limit.hpp>

#include <cstddef>

namespace anogate {

/// Flow:    see(bytes, now) → wrote(count) → see(...)...
class UnacknowledgedData {
public:
    /// `bytes`: not acknowledged now.
    void see(std::size_t bytes, ano::TimePoint now) noexcept {
        if (bytes < bytes_ || bytes_ == 0) since_ = now;
        bytes_ = bytes;
    }
    /// After see().
    void wrote(std::size_t count) noexcept { bytes_ += count; }

    std::size_t bytes() const noexcept { return bytes_; }
    /// The time without any acknowledgement although data waits for one; zero: none waits.
    ano::Duration age(ano::TimePoint now) const noexcept { return bytes_ == 0 ? ano::Duration{} : now - since_; }
    /// Whether that is much longer than the path needs: the connection may be interrupted. `measure` returns the RoundTrip; it
    /// is called only if needed.
    template <typename Measure>
    bool is_late(ano::TimePoint now, Measure measure) const {
        const ano::Duration waits = age(now);
        return waits > InFlightLimit::late_acknowledgement && waits > InFlightLimit::late_acknowledgement + 2 * measure().now;
    }

private:
    std::size_t bytes_ = 0;
    ano::TimePoint since_{};
};

}    // namespace anogate
