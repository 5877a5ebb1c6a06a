// sim:imu. An inertial unit on a table that sways a little.
#pragma once
#include "body.hpp"
#include "inertial_unit.hpp"
#include "simulated_device.hpp"

namespace ano::world {

class Imu final : public SimulatedDevice {
public:
    static constexpr std::uint8_t usual_id = 0xDD;

    Imu(const Settings& settings, TimePoint start);

private:
    void advance() override;

    Hand hand_;
    Body body_;
    InertialUnit inertial_;
    float sway_ = 5;    // °
    std::int16_t barometer_offset_ = 0;
};

}    // namespace ano::world
