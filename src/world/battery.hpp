// A battery of three cells whose voltage falls with the charge used.
#pragma once
#include <algorithm>

namespace ano::world {

class Battery {
public:
    static constexpr double full = 12.6, empty = 10.8;    // V, without load
    static constexpr double hover = 14;                   // A

    /// `load`: as a multiple of the load in hover, which empties the battery in `flight_time` seconds.
    void step(double dt, double load, double flight_time) noexcept {
        current_ = 0.4 + hover * load;
        charge_ = std::max(charge_ - dt * load / flight_time, 0.0);
    }
    void charge(double share) noexcept { charge_ = std::clamp(share, 0.0, 1.0); }
    double charge() const noexcept { return charge_; }
    double voltage() const noexcept { return empty + (full - empty) * charge_ - 0.02 * current_; }
    double current() const noexcept { return current_; }

private:
    double charge_ = 1;
    double current_ = 0.4;
};

}    // namespace ano::world
