// Computes the motors from the target, by nested control loops: position, velocity, attitude, rates.
#pragma once
#include "body.hpp"

namespace ano::world {

/// The gain of each loop, in 1/s.
struct Gains {
    float position = 1, velocity = 2.5f, attitude = 7, rate = 18, integral = 0.8f;
};

class Pilot {
public:
    static constexpr double max_lean = 30 * degree;
    static constexpr double max_climb = 2, max_sink = 1;    // m/s
    static constexpr double max_yaw_rate = 90 * degree;     // rad/s
    static constexpr double max_acceleration = 5;           // m/s²

    /// Resets the targets to the state of `body`.
    void reset(const Body& body) noexcept;

    /// Leans by `lean`, with `throttle` as a share of full thrust.
    Motors lean(const Body& body, Angles lean, double throttle, const Gains& gains) noexcept;
    /// Leans by `lean`, and climbs with `climb`, m/s.
    Motors lean_and_climb(const Body& body, Angles lean, double climb, const Gains& gains, double dt) noexcept;
    /// Flies with `velocity` over ground, m/s.
    Motors fly(const Body& body, Vector velocity, const Gains& gains, double dt) noexcept;
    /// Flies to `there`, no faster than `speed`, m/s.
    Motors go(const Body& body, Vector there, double speed, const Gains& gains, double dt) noexcept;

    void turn(double rate, double dt) noexcept { yaw_ = wrapped(yaw_ + std::clamp(rate, -max_yaw_rate, max_yaw_rate) * dt); }
    void turn_towards(double yaw, double dt) noexcept;
    double yaw() const noexcept { return yaw_; }
    /// The last target attitude.
    Angles aimed_attitude() const noexcept { return attitude_; }
    Vector aimed_velocity() const noexcept { return velocity_; }

private:
    double thrust_for(const Body& body, double upwards) const noexcept;

    double yaw_ = 0;
    Vector integral_;
    Angles attitude_;
    Vector velocity_;
};

}    // namespace ano::world
