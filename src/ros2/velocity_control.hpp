// Velocities of a ROS 2 node (geometry_msgs/Twist) as frames 0x41. No I/O, no clock.
#pragma once
#include <ano/time.hpp>
#include <ros/cdr_reader.hpp>
#include <ros2/input_guard.hpp>
#include <ros2/settings.hpp>

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace anogate {

/// The fields of 0x41, in the units of the wire. Roll and pitch are always 0.
struct VelocityFrame {
    std::int16_t throttle = 0;           // per mille
    std::int16_t yaw_rate = 0;           // °/s, to the left
    std::int16_t x = 0, y = 0, z = 0;    // cm/s: forward, left, up
    bool operator==(const VelocityFrame&) const = default;
};

/// Velocities are passed on only while the device reports a flight mode in which they count. In other modes the throttle of the same
/// frame counts, so it is never 0 but the value at which the device hovers.
class VelocityControl {
public:
    static constexpr ano::Duration mode_age = std::chrono::seconds{2};    // the last 0x06 is valid for this time
    static constexpr ano::Duration silence = InputGuard::silence;         // after it, the device is stopped once

    VelocityControl(std::uint32_t hover_throttle, std::vector<std::uint8_t> modes)
        : hover_throttle_{hover_throttle}, modes_{std::move(modes)} {}

    /// The device sent 0x06.
    void on_mode(std::uint8_t mode, ano::TimePoint now) noexcept {
        mode_ = mode;
        mode_at_ = now;
    }
    /// InputFault::none: `frame` is to be sent.
    InputFault on_twist(const Twist& twist, ano::TimePoint now, VelocityFrame& frame) noexcept;
    /// To be called when due(): the frame that stops the device after the last velocity, if the mode still allows it.
    std::optional<VelocityFrame> on_time(ano::TimePoint now) noexcept;
    std::optional<ano::TimePoint> due() const noexcept;

private:
    InputFault mode_fault(ano::TimePoint now) const noexcept;
    VelocityFrame stopped() const noexcept { return {static_cast<std::int16_t>(hover_throttle_ / 100), 0, 0, 0, 0}; }

    std::uint32_t hover_throttle_;    // thousandths of a percent
    std::vector<std::uint8_t> modes_;
    std::optional<std::uint8_t> mode_;
    ano::TimePoint mode_at_{};
    std::optional<ano::TimePoint> sent_at_;    // the last velocity; std::nullopt: the device was stopped
};

}    // namespace anogate
