// How long an answer of one device may take, by its own round trips (RFC 6298).
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <optional>

namespace ano::host {

class RoundTrip {
public:
    static constexpr Duration first = std::chrono::milliseconds{300};    // before anything was measured
    static constexpr Duration floor = std::chrono::milliseconds{30};
    static constexpr Duration ceiling = std::chrono::seconds{2};
    /// The minimum that is added to the mean: a USB adapter delivers what it received only every 16 ms.
    static constexpr Duration granularity = std::chrono::milliseconds{20};
    /// After this many repeated exchanges in a row, one is measured from its first send: where every answer takes longer than the
    /// time-out, nothing would ever be measured otherwise.
    static constexpr int repeated_enough = 3;

    /// An exchange was answered `since_first` after its first send. One that was repeated is not measured, since it is not known which
    /// send was answered (Karn's rule).
    void answered(Duration since_first, bool repeated) noexcept;

    /// SRTT + 4 RTTVAR, within floor and ceiling.
    Duration time_out() const noexcept;
    /// The time-out of a send after `losses` of the same exchange: doubled for each, within the ceiling.
    Duration time_out_after(unsigned losses) const noexcept;
    /// SRTT; std::nullopt before the first measurement.
    std::optional<Duration> smoothed() const noexcept { return smoothed_; }

private:
    std::optional<Duration> smoothed_;
    Duration variation_{};
    int repeated_in_a_row_ = 0;
};

}    // namespace ano::host
