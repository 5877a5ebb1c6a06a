#include <ros2/arrival_envelope.hpp>

#include <algorithm>
#include <cmath>

namespace anogate {

std::uint64_t ArrivalEnvelope::stamp(std::uint64_t arrival_ns) noexcept {
    const std::size_t last = (next_ + window - 1) % window;
    if (count_ > 0 && arrival_ns < arrivals_[last]) {    // another clock
        count_ = 0;
        is_period_known_ = false;
        stamp_ns_ = 0;
    }
    arrivals_[next_] = arrival_ns;
    next_ = (next_ + 1) % window;
    count_ = std::min(count_ + 1, window);
    stamp_ns_ = std::max(stamp_ns_, estimate());
    return stamp_ns_;
}

double ArrivalEnvelope::time(std::size_t i) const noexcept {
    const std::size_t last = (next_ + window - 1) % window;
    const std::uint64_t arrival = arrivals_[(next_ + window - count_ + i) % window];
    return -static_cast<double>(arrivals_[last] - arrival);
}

// The slope of the line is averaged over several windows: the sender's clock is even, and an error of the slope counts most at the end.
std::uint64_t ArrivalEnvelope::estimate() noexcept {
    constexpr double share = 1.0 / window;
    const std::uint64_t arrival = arrivals_[(next_ + window - 1) % window];
    if (count_ < needed) return arrival;
    if (count_ == window && is_period_known_) period_ += share * (slope() - period_);
    else if (!is_period_known_) period_ = slope();
    is_period_known_ = is_period_known_ || count_ == window;
    shorten();
    const double delay = delay_from(0);
    if (!is_period_known_ || mean_delay(delay) > period_) return arrival;
    return arrival - static_cast<std::uint64_t>(std::clamp(delay, 0.0, period_));
}

// A message that was lost, or another rate, shifts all following arrivals: if none of the last ones is near the line, the older ones are
// forgotten.
void ArrivalEnvelope::shorten() noexcept {
    if (count_ == needed || delay_from(0) - delay_from(count_ - needed) < period_ / 2) return;
    count_ = needed;
    const double gap = mean_gap(needed);
    if (std::abs(gap - period_) < period_ / 3) return;
    period_ = gap;
    is_period_known_ = false;
}

// Of all lines below the arrivals, the one with the least sum of delays: the edge of their lower convex hull below the middle.
double ArrivalEnvelope::slope() const noexcept {
    std::array<std::size_t, window> hull;
    std::size_t size = 0;
    for (std::size_t i = 0; i < count_; ++i) {
        const auto is_above = [&] {
            const double a = static_cast<double>(hull[size - 1] - hull[size - 2]), b = static_cast<double>(i - hull[size - 2]);
            return (time(hull[size - 1]) - time(hull[size - 2])) * b >= (time(i) - time(hull[size - 2])) * a;
        };
        while (size >= 2 && is_above()) --size;
        hull[size++] = i;
    }
    const double middle = static_cast<double>(count_ - 1) / 2;
    std::size_t right = 1;
    while (static_cast<double>(hull[right]) < middle) ++right;
    const std::size_t from = hull[right - 1], to = hull[right];
    return (time(to) - time(from)) / static_cast<double>(to - from);
}

double ArrivalEnvelope::mean_gap(std::size_t last) const noexcept { return -time(count_ - last) / static_cast<double>(last - 1); }

double ArrivalEnvelope::delay_from(std::size_t i) const noexcept {
    double least = 0;
    for (; i < count_; ++i) least = std::min(least, time(i) + period_ * static_cast<double>(count_ - 1 - i));
    return -least;
}

double ArrivalEnvelope::mean_delay(double delay_of_last) const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < count_; ++i) sum += time(i) + period_ * static_cast<double>(count_ - 1 - i);
    return delay_of_last + sum / static_cast<double>(count_);
}

}    // namespace anogate
