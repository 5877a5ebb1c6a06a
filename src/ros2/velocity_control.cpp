#include <ros2/velocity_control.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace anogate {
namespace {

constexpr double max_yaw_rate = 200;    // °/s, as in the protocol text

std::int16_t limited(double value, double limit) noexcept {
    return static_cast<std::int16_t>(std::lround(std::clamp(value, -limit, limit)));
}

std::int16_t centimetres(double metres) noexcept { return limited(100 * metres, std::numeric_limits<std::int16_t>::max()); }

bool is_finite(const Twist& twist) noexcept {
    double sum = 0;
    for (const auto& part : {twist.linear, twist.angular})
        for (const double value : part) sum += std::isfinite(value) ? 0 : 1;
    return sum == 0;
}

}    // namespace

InputFault VelocityControl::mode_fault(ano::TimePoint now) const noexcept {
    if (!mode_ || now - mode_at_ > mode_age) return InputFault::unknown_mode;
    return std::find(modes_.begin(), modes_.end(), *mode_) == modes_.end() ? InputFault::wrong_mode : InputFault::none;
}

InputFault VelocityControl::on_twist(const Twist& twist, ano::TimePoint now, VelocityFrame& frame) noexcept {
    if (!is_finite(twist)) return InputFault::malformed;
    if (const InputFault fault = mode_fault(now); fault != InputFault::none) return fault;
    constexpr double degree = 180 / std::numbers::pi;
    frame = stopped();
    frame.yaw_rate = limited(degree * twist.angular[2], max_yaw_rate);
    frame.x = centimetres(twist.linear[0]);
    frame.y = centimetres(twist.linear[1]);
    frame.z = centimetres(twist.linear[2]);
    sent_at_ = now;
    return InputFault::none;
}

std::optional<ano::TimePoint> VelocityControl::due() const noexcept {
    return sent_at_ ? std::optional{*sent_at_ + silence} : std::nullopt;
}

std::optional<VelocityFrame> VelocityControl::on_time(ano::TimePoint now) noexcept {
    if (!sent_at_ || now - *sent_at_ < silence) return std::nullopt;
    sent_at_.reset();
    return mode_fault(now) == InputFault::none ? std::optional{stopped()} : std::nullopt;
}

}    // namespace anogate
