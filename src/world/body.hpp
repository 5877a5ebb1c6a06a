// A quadrotor as a rigid body: four motors with a lag, drag, gravity and the ground.
#pragma once
#include "vector.hpp"

#include <array>

namespace ano::world {

/// The requested thrust of each motor, 0 to 1: front right, front left, rear left, rear right.
using Motors = std::array<double, 4>;

class Body {
public:
    static constexpr double mass = 1.2;                                 // kg
    static constexpr Vector inertia{0.012, 0.012, 0.022};               // kg·m²
    static constexpr double lever = 0.16;                               // m, of each motor from both axes
    static constexpr double max_thrust = 6.5;                           // N, of one motor
    static constexpr double hover = mass * gravity / max_thrust / 4;    // share of the maximum thrust that balances the weight
    static constexpr double yaw_torque = 0.02;                          // N·m for each N
    static constexpr double motor_lag = 0.04;                           // s
    static constexpr double max_rate = 50;                              // rad/s: drag of the air limits it
    static constexpr double drag = 0.3;                                 // N for each m/s

    void step(double dt, const Motors& wanted, Vector wind) noexcept;
    /// Sets the attitude directly, as of a vehicle held by a hand.
    void hold(Attitude attitude, double dt) noexcept;

    bool on_ground() const noexcept { return on_ground_; }
    Vector position() const noexcept { return position_; }
    Vector velocity() const noexcept { return velocity_; }
    const Attitude& attitude() const noexcept { return attitude_; }
    Angles angles() const noexcept { return attitude_.angles(); }
    Vector rates() const noexcept { return rates_; }
    const Motors& motors() const noexcept { return motors_; }
    /// The measurement of an ideal accelerometer, m/s²: at rest, gravity upwards.
    Vector felt() const noexcept { return felt_; }

private:
    Vector torque() const noexcept;
    void touch_ground(Vector where) noexcept;

    bool on_ground_ = true;
    Vector position_, velocity_, rates_, felt_{0, 0, gravity};
    Attitude attitude_;
    Motors motors_{};
};

}    // namespace ano::world
