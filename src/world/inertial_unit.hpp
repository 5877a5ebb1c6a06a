// Accelerometer, gyroscope and compass of one device, with the parameters and the hand that a calibration needs.
#pragma once
#include "hand.hpp"
#include "sensors.hpp"

#include <ano/typed.hpp>
#include <device/parameters.hpp>

#include <functional>

namespace ano::world {

class InertialUnit {
public:
    explicit InertialUnit(Noise& chance) noexcept : accelerometer_{chance}, compass_{chance}, gyroscope_{chance} {}

    /// Adds the 21 parameters. When a host wants raw values, and `may_be_turned`, `hand` turns the device as that calibration
    /// needs it: long enough on each side for what is sent `hz` times a second, of the compass half as often.
    void add_calibrations(device::Parameters& parameters, Hand& hand, unsigned hz, const std::function<bool()>& may_be_turned);

    /// What they say of a device that feels and turns so.
    Draft<"inertial"> inertial(Vector felt, Vector rates, Noise& chance) const noexcept;
    Draft<"compass"> compass(const Attitude& attitude, Noise& chance) const noexcept;

private:
    Accelerometer accelerometer_;
    Compass compass_;
    Gyroscope gyroscope_;
};

}    // namespace ano::world
