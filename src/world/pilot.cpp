#include "pilot.hpp"

namespace ano::world {

void Pilot::reset(const Body& body) noexcept {
    yaw_ = body.angles().yaw;
    integral_ = velocity_ = {};
    attitude_ = {0, 0, yaw_};
}

void Pilot::turn_towards(double yaw, double dt) noexcept {
    const double left = wrapped(yaw - yaw_);
    if (dt > 0) turn(std::clamp(left / dt, -max_yaw_rate, max_yaw_rate), dt);
}

Motors Pilot::lean(const Body& body, Angles lean, double throttle, const Gains& gains) noexcept {
    attitude_ = {std::clamp(lean.roll, -max_lean, max_lean), std::clamp(lean.pitch, -max_lean, max_lean), yaw_};
    const Angles is = body.angles();
    const double k = double{gains.attitude};
    const Vector rates{k * (attitude_.roll - is.roll), k * (attitude_.pitch - is.pitch),
                       std::clamp(k / 2 * wrapped(yaw_ - is.yaw), -2 * max_yaw_rate, 2 * max_yaw_rate)};
    const Vector more = double{gains.rate} * (rates - body.rates());
    // The torque of each axis, as a share of full thrust of each motor.
    const double roll = Body::inertia.x * more.x / (4 * Body::lever * Body::max_thrust);
    const double pitch = Body::inertia.y * more.y / (4 * Body::lever * Body::max_thrust);
    const double yaw = std::clamp(Body::inertia.z * more.z / (4 * Body::yaw_torque * Body::max_thrust), -0.15, 0.15);
    return {throttle - roll - pitch + yaw, throttle + roll - pitch - yaw, throttle + roll + pitch + yaw,
            throttle - roll + pitch - yaw};
}

// The share of full thrust for the vertical acceleration `upwards`, m/s².
double Pilot::thrust_for(const Body& body, double upwards) const noexcept {
    const Angles is = body.angles();
    const double part = std::max(std::cos(is.roll) * std::cos(is.pitch), 0.5);
    return std::clamp(Body::mass * upwards / part / Body::max_thrust / 4, 0.05, 0.95);
}

Motors Pilot::lean_and_climb(const Body& body, Angles wanted, double climb, const Gains& gains, double dt) noexcept {
    velocity_.z = std::clamp(climb, -max_sink, max_climb);
    const double off = velocity_.z - body.velocity().z;
    integral_.z = std::clamp(integral_.z + double{gains.integral} * off * dt, -2.0, 2.0);
    return lean(body, wanted, thrust_for(body, gravity + 2 * double{gains.velocity} * off + integral_.z), gains);
}

Motors Pilot::fly(const Body& body, Vector velocity, const Gains& gains, double dt) noexcept {
    velocity_.x = velocity.x;
    velocity_.y = velocity.y;
    const Vector off{velocity.x - body.velocity().x, velocity.y - body.velocity().y, 0};
    const Vector flat = no_longer(Vector{integral_.x, integral_.y, 0} + double{gains.integral} * dt * off, max_acceleration / 2);
    integral_.x = flat.x;
    integral_.y = flat.y;
    const Vector wanted = no_longer(double{gains.velocity} * off + flat, max_acceleration);
    const double yaw = body.angles().yaw;
    const double forward = wanted.x * std::cos(yaw) + wanted.y * std::sin(yaw);
    const double left = wanted.y * std::cos(yaw) - wanted.x * std::sin(yaw);
    return lean_and_climb(body, {-std::atan2(left, gravity), std::atan2(forward, gravity), 0}, velocity.z, gains, dt);
}

Motors Pilot::go(const Body& body, Vector there, double speed, const Gains& gains, double dt) noexcept {
    const Vector left = there - body.position();
    Vector velocity = no_longer(double{gains.position} * Vector{left.x, left.y, 0}, speed);
    velocity.z = std::clamp(1.5 * double{gains.position} * left.z, -max_sink, max_climb);
    return fly(body, velocity, gains, dt);
}

}    // namespace ano::world
