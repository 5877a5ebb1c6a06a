#include <host/round_trip.hpp>
#include <host/window.hpp>

#include <algorithm>

namespace ano::host {

void RoundTrip::answered(Duration since_first, bool repeated) noexcept {
    if (repeated && (++repeated_in_a_row_ < repeated_enough || !doubled_)) return;
    repeated_in_a_row_ = 0;
    doubled_ = false;
    least_ = std::min(least_, since_first);
    if (!smoothed_) {
        smoothed_ = since_first;
        variation_ = since_first / 2;
        return;
    }
    const Duration off = since_first - *smoothed_;
    variation_ += (std::chrono::abs(off) - variation_) / 4;
    *smoothed_ += off / 8;
}

void RoundTrip::answered_behind(std::size_t others, Duration time) noexcept {
    std::optional<Duration>& mean = others == 0 ? by_itself_ : behind_others_;
    const auto number = static_cast<double>(others);
    if (others > 0) others_ = mean ? others_ + (number - others_) / 8 : number;
    mean = mean ? *mean + (time - *mean) / 8 : time;
}

std::size_t RoundTrip::bearable() const noexcept {
    constexpr std::size_t least = 2, most = Window::max_size;
    if (!by_itself_ || !behind_others_ || *behind_others_ <= *by_itself_) return most;
    const double all = others_ * static_cast<double>(max_wait.count()) /
                       static_cast<double>((*behind_others_ - *by_itself_).count());
    return all >= static_cast<double>(most - 1) ? most : std::max(least, 1 + static_cast<std::size_t>(all));
}

Duration RoundTrip::time_out() const noexcept {
    if (!smoothed_) return first;
    return std::clamp(*smoothed_ + std::max(granularity, 4 * variation_), floor, ceiling);
}

Duration RoundTrip::time_out_after(unsigned losses, bool answers, bool by_itself) const noexcept {
    if (smoothed_ && !grows()) losses = answers && losses < losses_in_a_row ? 0 : std::min(losses, max_doublings);
    Duration time = by_itself && smoothed_ ? std::min(time_out(), first + 4 * least_) : time_out();
    for (; losses > 0 && time < ceiling; --losses) time *= 2;
    return std::min(time, ceiling);
}

}    // namespace ano::host
