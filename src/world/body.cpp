#include "body.hpp"

#include <numeric>

namespace ano::world {

Vector Body::torque() const noexcept {
    const auto& [fr, fl, rl, rr] = motors_;
    const double n = max_thrust;
    return {lever * n * (fl + rl - fr - rr), lever * n * (rl + rr - fr - fl), yaw_torque * n * (fr + rl - fl - rr)};
}

void Body::step(double dt, const Motors& wanted, Vector wind) noexcept {
    for (std::size_t i = 0; i < motors_.size(); ++i)
        motors_[i] += (std::clamp(wanted[i], 0.0, 1.0) - motors_[i]) * std::min(dt / motor_lag, 1.0);
    const Vector t = torque();
    const Vector spin{inertia.x * rates_.x, inertia.y * rates_.y, inertia.z * rates_.z};
    const Vector turning = t - cross(rates_, spin);
    rates_ = no_longer(rates_ + dt * Vector{turning.x / inertia.x, turning.y / inertia.y, turning.z / inertia.z}, max_rate);
    attitude_ = attitude_.turned(rates_, dt);

    const Vector before = position_;
    const double thrust = max_thrust * std::accumulate(motors_.begin(), motors_.end(), 0.0);
    const Vector pull = attitude_.turn({0, 0, thrust}) - drag * (velocity_ - wind);
    const Vector acceleration = (1 / mass) * pull - Vector{0, 0, gravity};
    velocity_ = velocity_ + dt * acceleration;
    position_ = position_ + dt * velocity_;
    felt_ = attitude_.inverse().turn((1 / mass) * pull);
    const bool stood = on_ground_;
    on_ground_ = position_.z <= 0 && velocity_.z <= 0;
    if (on_ground_) touch_ground(stood ? before : position_);
}

// The vehicle lands upright and then does not move.
void Body::touch_ground(Vector where) noexcept {
    position_ = {where.x, where.y, 0};
    velocity_ = rates_ = {};
    attitude_ = Attitude::of({0, 0, attitude_.angles().yaw});
    felt_ = {0, 0, gravity};
}

void Body::hold(Attitude attitude, double dt) noexcept {
    const Attitude back = attitude_.inverse();
    const Vector there{attitude.x, attitude.y, attitude.z}, from{back.x, back.y, back.z};
    const double w = back.w * attitude.w - (from.x * there.x + from.y * there.y + from.z * there.z);
    const Vector v = back.w * there + attitude.w * from + cross(from, there);    // the rotation between the two attitudes
    rates_ = (w < 0 ? -2 : 2) / dt * v;
    attitude_ = attitude;
    felt_ = attitude_.inverse().turn({0, 0, gravity});
    motors_ = {};
}

}    // namespace ano::world
