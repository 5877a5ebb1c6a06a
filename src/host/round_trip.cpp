#include <host/round_trip.hpp>

#include <algorithm>

namespace ano::host {

void RoundTrip::answered(Duration since_first, bool repeated) noexcept {
    if (repeated && ++repeated_in_a_row_ < repeated_enough) return;
    repeated_in_a_row_ = 0;
    if (!smoothed_) {
        smoothed_ = since_first;
        variation_ = since_first / 2;
        return;
    }
    const Duration off = since_first - *smoothed_;
    variation_ += (std::chrono::abs(off) - variation_) / 4;
    *smoothed_ += off / 8;
}

Duration RoundTrip::time_out() const noexcept {
    if (!smoothed_) return first;
    return std::clamp(*smoothed_ + std::max(granularity, 4 * variation_), floor, ceiling);
}

Duration RoundTrip::time_out_after(unsigned losses) const noexcept {
    Duration time = time_out();
    for (; losses > 0 && time < ceiling; --losses) time *= 2;
    return std::min(time, ceiling);
}

}    // namespace ano::host
