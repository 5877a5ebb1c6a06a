#include "kinds.hpp"
#include "car.hpp"
#include "flight_controller.hpp"
#include "flow_sensor.hpp"
#include "imu.hpp"
#include "radio.hpp"

namespace ano::world {

std::unique_ptr<SimulatedDevice> make_device(std::string_view kind, const Settings& settings, TimePoint start) {
    if (kind == "imu") return std::make_unique<Imu>(settings, start);
    if (kind == "flow") return std::make_unique<FlowSensor>(settings, start);
    if (kind == "radio") return std::make_unique<Radio>(settings, start);
    if (kind == "car") return std::make_unique<Car>(settings, start);
    return std::make_unique<FlightController>(settings, start);
}

}    // namespace ano::world
