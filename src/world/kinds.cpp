#include "kinds.hpp"
#include "car.hpp"
#include "flight_controller.hpp"
#include "flow_sensor.hpp"
#include "imu.hpp"
#include "radio.hpp"

#include <algorithm>

namespace ano::world {
namespace {

using Made = std::unique_ptr<SimulatedDevice>;

template <class Device>
Made made(const Settings& settings, TimePoint start) {
    return std::make_unique<Device>(settings, start);
}

struct Row {
    std::string_view name;
    Made (*make)(const Settings& settings, TimePoint start);
};
constexpr Row rows[]{
    {"fc", made<FlightController>}, {"imu", made<Imu>}, {"flow", made<FlowSensor>}, {"radio", made<Radio>}, {"car", made<Car>},
};

}    // namespace

std::unique_ptr<SimulatedDevice> make_device(std::string_view kind, const Settings& settings, TimePoint start) {
    const auto* const row = std::find_if(std::begin(rows), std::end(rows), [&](const Row& r) { return r.name == kind; });
    return (row != std::end(rows) ? row : std::begin(rows))->make(settings, start);
}

}    // namespace ano::world
