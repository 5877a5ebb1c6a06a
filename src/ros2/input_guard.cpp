#include <ros2/input_guard.hpp>

#include <algorithm>

namespace anogate {

std::string_view format_fault(InputFault fault) noexcept {
    switch (fault) {
    case InputFault::none: return "";
    case InputFault::old: return "older than 0.5 s";
    case InputFault::other_publisher: return "from a second publisher";
    case InputFault::malformed: return "not valid";
    case InputFault::wrong_mode: return "flight mode without velocities";
    case InputFault::unknown_mode: return "flight mode not known (no 0x06)";
    case InputFault::not_sent: return "gateway not connected";
    }
    return "";
}

InputFault InputGuard::check(const Sample& sample, ano::TimePoint now) noexcept {
    const bool is_other = !has_publisher_ || sample.publisher != guid_;
    if (is_other && has_publisher_ && now - used_at_ < silence) return InputFault::other_publisher;
    const auto delay = static_cast<std::int64_t>(sample.received_ns - sample.sent_ns);
    constexpr ano::Duration pause = std::chrono::seconds{1};
    if (now - heard_at_ > pause) old_since_.reset();
    heard_at_ = now;
    const bool was_set_back = old_since_ && now - *old_since_ >= forget;
    if (is_other || was_set_back) least_delay_ns_ = delay;
    if (is_other || was_set_back) old_since_.reset();
    guid_ = sample.publisher;
    has_publisher_ = true;
    if (sample.sent_ns != 0) least_delay_ns_ = std::min(least_delay_ns_, delay);
    const bool waited_there = sample.sent_ns != 0 && delay - least_delay_ns_ > static_cast<std::int64_t>(max_age_ns);
    const bool waited_here = now - sample.received_at > std::chrono::nanoseconds{max_age_ns};
    if (waited_there || waited_here) {
        if (!old_since_) old_since_ = now;
        return InputFault::old;
    }
    old_since_.reset();
    used_at_ = now;
    return InputFault::none;
}

std::optional<Guid> InputGuard::publisher(ano::TimePoint now) const noexcept {
    return has_publisher_ && now - used_at_ < silence ? std::optional{guid_} : std::nullopt;
}

}    // namespace anogate
