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

    struct Owner {
        std::function<bool()> may_be_turned;    // by hand, now
        std::function<bool()> store;            // SimulatedDevice::store_values()
    };
    /// Adds the 21 parameters. If a host clears a calibration, to get raw values, and the device may be turned, `hand` turns it
    /// as that calibration needs: long enough on each face for frames that are sent `hz` times per second, and half as often for
    /// the compass. After the host has stored the calibration, `hand` continues for some seconds, so that it can be verified.
    void add_calibrations(device::Parameters& parameters, Hand& hand, unsigned hz, const Owner& owner);

    /// The message with this acceleration (m/s²) and rotation (rad/s).
    Draft<"inertial"> inertial(Vector felt, Vector rates, Noise& chance) const noexcept;
    Draft<"compass"> compass(const Attitude& attitude, Noise& chance) const noexcept;

private:
    Accelerometer accelerometer_;
    Compass compass_;
    Gyroscope gyroscope_;
};

}    // namespace ano::world
