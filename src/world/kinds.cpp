#include "kinds.hpp"
#include "car.hpp"
#include "flight_controller.hpp"
#include "flow_sensor.hpp"
#include "imu.hpp"
#include "lx_unit.hpp"
#include "radio.hpp"

namespace ano::world {
namespace {

using Made = std::unique_ptr<SimulatedDevice>;

template <class Device>
Made make(const Settings& settings, TimePoint start) {
    return std::make_unique<Device>(settings, start);
}

struct Row {
    std::string_view name;
    Made (*make)(const Settings&, TimePoint);
};
constexpr Row rows[]{
    {"fc", make<FlightController>}, {"imu", make<Imu>}, {"flow", make<FlowSensor>},
    {"radio", make<Radio>},         {"car", make<Car>}, {"lx", make<LxUnit>},
};

}    // namespace

std::unique_ptr<SimulatedDevice> make_device(std::string_view name, const Settings& settings, TimePoint start) {
    for (const Row& row : rows)
        if (row.name == name) return row.make(settings, start);
    return rows[0].make(settings, start);
}

}    // namespace ano::world
