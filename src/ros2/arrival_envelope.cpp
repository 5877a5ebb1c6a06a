#include <ros2/arrival_envelope.hpp>

#include <algorithm>
#include <cmath>

namespace anogate {

std::uint64_t ArrivalEnvelope::stamp(std::uint64_t arrival_ns) noexcept {
    if (count_ > 0 && arrival_ns < arrivals_[count_ - 1]) *this = {};    // another clock
    add(arrival_ns);
    stamp_ns_ = std::max(stamp_ns_, estimate());
    return stamp_ns_;
}

void ArrivalEnvelope::add(std::uint64_t arrival_ns) noexcept {
    if (count_ == window) std::copy(arrivals_.begin() + 1, arrivals_.end(), arrivals_.begin());
    else ++count_;
    arrivals_[count_ - 1] = arrival_ns;
}

// The slope of the line is averaged over several windows: the sender's clock is even, and an error of the slope counts most at the end.
// It is not needed for every arrival.
std::uint64_t ArrivalEnvelope::estimate() noexcept {
    constexpr double share = static_cast<double>(needed) / window;
    const std::uint64_t arrival = arrivals_[count_ - 1];
    if (!is_period_known_ && count_ < window) return arrival;
    Times times;
    for (std::size_t i = 0; i < count_; ++i) times[i] = -static_cast<double>(arrival - arrivals_[i]);
    if (!is_period_known_) {
        period_ = slope(times);
        is_period_known_ = true;
    } else if (count_ == window && ++since_slope_ >= needed) {
        period_ += share * (slope(times) - period_);
        since_slope_ = 0;
    }
    shorten(times);
    if (!is_period_known_ || count_ < needed) return arrival;
    const double delay = delay_from(0, times);
    if (mean_delay(delay, times) > period_) return arrival;
    return arrival - static_cast<std::uint64_t>(std::clamp(delay, 0.0, period_));
}

// A message that was lost, or another rate, shifts all following arrivals: if none of the last ones is near the line, the older ones are
// forgotten.
void ArrivalEnvelope::shorten(Times& times) noexcept {
    if (count_ <= needed || delay_from(0, times) - delay_from(count_ - needed, times) < period_ / 2) return;
    std::copy(arrivals_.begin() + static_cast<std::ptrdiff_t>(count_ - needed),
              arrivals_.begin() + static_cast<std::ptrdiff_t>(count_), arrivals_.begin());
    std::copy(times.begin() + static_cast<std::ptrdiff_t>(count_ - needed), times.begin() + static_cast<std::ptrdiff_t>(count_),
              times.begin());
    count_ = needed;
    const double gap = -times.front() / static_cast<double>(needed - 1);
    is_period_known_ = std::abs(gap - period_) < period_ / 3;
}

// Of all lines below the arrivals, the one with the least sum of delays: the edge of their lower convex hull below the middle.
double ArrivalEnvelope::slope(const Times& times) const noexcept {
    std::array<std::size_t, window> hull;
    std::size_t size = 0;
    for (std::size_t i = 0; i < count_; ++i) {
        const auto is_above = [&] {
            const std::size_t from = hull[size - 2], middle = hull[size - 1];
            return (times[middle] - times[from]) * static_cast<double>(i - from) >=
                   (times[i] - times[from]) * static_cast<double>(middle - from);
        };
        while (size >= 2 && is_above()) --size;
        hull[size++] = i;
    }
    std::size_t right = 1;
    while (2 * hull[right] < count_ - 1) ++right;
    const std::size_t from = hull[right - 1], to = hull[right];
    return (times[to] - times[from]) / static_cast<double>(to - from);
}

double ArrivalEnvelope::delay_from(std::size_t i, const Times& times) const noexcept {
    double least = 0;
    for (; i < count_; ++i) least = std::min(least, times[i] + period_ * static_cast<double>(count_ - 1 - i));
    return -least;
}

double ArrivalEnvelope::mean_delay(double delay_of_last, const Times& times) const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < count_; ++i) sum += times[i] + period_ * static_cast<double>(count_ - 1 - i);
    return delay_of_last + sum / static_cast<double>(count_);
}

}    // namespace anogate
