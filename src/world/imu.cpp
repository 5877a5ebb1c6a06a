#include "imu.hpp"
#include "say_attitude.hpp"

namespace ano::world {

Imu::Imu(const Settings& settings, TimePoint start)
    : SimulatedDevice{{.id = settings.id != 0 ? settings.id : usual_id, .name = "SimIMU"}, settings, start}, inertial_{chance()} {
    auto& parameters = device().parameters();
    parameters.add("SIM_SWAY", sway_, {.info = "tilt of the swaying table, degrees", .min = 0, .max = 30});
    parameters.add("SIM_BAR_OFFSET", barometer_offset_, {.info = "barometer error, cm", .min = -1000, .max = 1000});
    inertial_.add_calibrations(parameters, hand_, hz(), {[] { return true; }, [this] { return store_values(); }});
    parameters.on_save([this] { return store_values(); });
    every(at_rate(hz()), [this] { emit(inertial_.inertial(body_.felt(), body_.rates(), chance())); });
    every(at_rate(hz()), [this] { emit(euler_of(body_.angles(), euler_signs(), chance())); });
    every(at_rate(hz()), [this] { emit(quaternion_of(body_.attitude())); });
    every(at_rate(hz() / 2), [this] { emit(inertial_.compass(body_.attitude(), chance())); });
    every(at_rate(hz() / 5), [this] {
        Draft<"altitude"> altitude;
        fill<"alt_bar">(altitude, barometer_offset_ + 5 * chance().normal());
        emit(altitude);
    });
}

void Imu::advance() {
    const double sway = double{sway_} * degree;
    const Attitude swayed = Attitude::of({sway * std::sin(0.7 * time()), 0.75 * sway * std::sin(0.5 * time()), 0});
    body_.hold(hand_.holds() ? hand_.next(dt) : swayed, dt);
}

}    // namespace ano::world
