// Wind: a mean velocity and gusts.
#pragma once
#include "noise.hpp"
#include "vector.hpp"

namespace ano::world {

class Weather {
public:
    /// `speed`: mean, m/s. `from`: its direction, degrees from north, clockwise. `gusty`: strength of the gusts as a share of `speed`.
    void step(double dt, double speed, double from, double gusty, Noise& chance) noexcept {
        constexpr double lasts = 2;    // s, duration of a gust
        const double size = gusty * speed * std::sqrt(2 * dt / lasts);
        gust_ = (1 - dt / lasts) * gust_ + size * Vector{chance.normal(), chance.normal(), 0};
        wind_ = gust_ - speed * Vector{std::cos(from * degree), -std::sin(from * degree), 0};
    }
    /// The velocity of the air, m/s.
    Vector wind() const noexcept { return wind_; }

private:
    Vector gust_, wind_;
};

}    // namespace ano::world
