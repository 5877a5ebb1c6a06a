// The messages of the simulated flight controller.
#include "flight_controller.hpp"
#include "room.hpp"
#include "say_attitude.hpp"

namespace ano::world {

FlightController::FlightController(const Settings& settings, TimePoint start)
    : SimulatedDevice{{.id = settings.id != 0 ? settings.id : address::flight_controller, .name = "SimFC"}, settings, start},
      flight_{settings_, [this](std::string_view text,
                                bool is_bad) { device().log(text, is_bad ? device::LogColor::red : device::LogColor::green); }},
      inertial_{chance()},
      satellites_{~settings.seed} {
    add_parameters();
    add_commands();
    add_waypoints();
    add_streams();
}

void FlightController::add_streams() {
    every(at_rate(hz()), [this] { emit(inertial_.inertial(flight_.body().felt(), flight_.body().rates(), chance())); });
    every(at_rate(hz()), [this] { emit(euler_of(flight_.body().angles(), euler_signs(), chance())); });
    every(at_rate(hz() / 2), [this] { emit(inertial_.compass(flight_.body().attitude(), chance())); });
    every(at_rate(hz() / 2), [this] { emit(quaternion_of(flight_.body().attitude())); });
    every(at_rate(hz() / 2), [this] { altitude(); });
    every(at_rate(hz() / 2), [this] { movement(); });
    every(at_rate(hz() / 5), [this] { position(); });
    every(at_rate(Satellites::rate), [this] { satellites(); });
    every(at_rate(hz() / 10), [this] { mode(); });
    every(at_rate(hz() / 10), [this] { targets(); });
    every(at_rate(hz() / 10), [this] { outputs(); });
    every(at_rate(1), [this] { health(); });
    every(at_rate(1), [this] { surroundings(); });
    every(at_rate(1), [this] { flexible(); });
    every(at_rate(TestPicture::frames), [this] {
        if (pictures_ != 0) emit(picture_.next());
    });
}

void FlightController::altitude() {
    const double height = 100 * flight_.body().position().z;
    Draft<"altitude"> draft;
    fill<"alt_bar">(draft, height + barometer_offset_ + 5 * chance().normal());
    fill<"alt_add">(draft, height + range_offset_ + 0.5 * chance().normal());
    fill<"alt_fu">(draft, height);
    fill<"alt_sta">(draft, 1);
    emit(draft);
}

void FlightController::movement() {
    const Vector v = 100 * flight_.body().velocity();
    Draft<"velocity"> draft;
    fill<"speed_x">(draft, v.x);
    fill<"speed_y">(draft, v.y);
    fill<"speed_z">(draft, v.z);
    emit(draft);
}

void FlightController::position() {
    const Vector p = 100 * flight_.offset();
    Draft<"position"> draft;
    fill<"pos_x">(draft, p.x);
    fill<"pos_y">(draft, p.y);
    fill<"pos_z">(draft, p.z);
    emit(draft);
}

void FlightController::satellites() { emit(satellites_.look(flight_.body().position(), flight_.body().velocity(), home_)); }

void FlightController::mode() {
    const device::CommandId now = command_of(flight_.task());
    Draft<"mode"> draft;
    fill<"mode">(draft, settings_.mode);
    fill<"sflag">(draft, static_cast<double>(flight_.safety()));
    fill<"cid">(draft, now[0]);
    fill<"cmd0">(draft, now[1]);
    fill<"cmd1">(draft, now[2]);
    emit(draft);
}

void FlightController::targets() {
    const Angles a = flight_.pilot().aimed_attitude();
    Draft<"target_attitude"> attitude;
    fill<"tar_rol">(attitude, a.roll / degree);
    fill<"tar_pit">(attitude, a.pitch / degree);
    fill<"tar_yaw">(attitude, a.yaw / degree);
    emit(attitude);
    const Vector v = 100 * flight_.pilot().aimed_velocity();
    Draft<"target_velocity"> velocity;
    fill<"tar_speed_x">(velocity, v.x);
    fill<"tar_speed_y">(velocity, v.y);
    fill<"tar_speed_z">(velocity, v.z);
    emit(velocity);
}

void FlightController::outputs() {
    const Motors& m = flight_.body().motors();
    Draft<"pwm"> draft;
    fill<"pwm1">(draft, 100 * m[0]);
    fill<"pwm2">(draft, 100 * m[1]);
    fill<"pwm3">(draft, 100 * m[2]);
    fill<"pwm4">(draft, 100 * m[3]);
    emit(draft);
}

void FlightController::health() {
    Draft<"power"> power;
    fill<"voltage">(power, flight_.battery().voltage());
    fill<"current">(power, flight_.battery().current());
    emit(power);
    Draft<"module_status"> modules;
    fill<"sta_g_vel">(modules, 2);
    fill<"sta_g_pos">(modules, 2);
    fill<"sta_gps">(modules, 3);
    fill<"sta_alt_add">(modules, 2);
    emit(modules);
    const bool is_locked = flight_.safety() == Flight::Safety::locked;
    Draft<"rgb"> lights;
    fill<"bri_r">(lights, is_locked ? 10 : 0);
    fill<"bri_g">(lights, is_locked ? 0 : 10);
    emit(lights);
}

void FlightController::surroundings() {
    const Vector w = flight_.safety() == Flight::Safety::airborne ? 100 * flight_.wind() : Vector{};
    Draft<"wind"> wind;
    fill<"wind_x">(wind, w.x);
    fill<"wind_y">(wind, w.y);
    emit(wind);
    const Vector from = flight_.offset();
    Draft<"return_home"> home;
    fill<"r_a">(home, wrapped(std::atan2(-from.y, -from.x)) / degree);
    fill<"r_d">(home, std::hypot(from.x, from.y));
    emit(home);
    const Scan points = scan_from(flight_.body().position(), flight_.body().angles().yaw);
    Draft<"ranging", "scan"> scan;
    static_cast<void>(scan.set<"points">(Bytes{points}));
    emit(scan);
    Draft<"ranging"> down;
    fill<"dist">(down, 1000 * flight_.body().position().z);
    emit(down);
}

// As a layout: {"id": "0xF9", "fields": [{"name": "charge", "type": "u8", "unit": "%"}, {"name": "wind", "type": "f32", "unit":
// "m/s"}]}
void FlightController::flexible() {
    std::array<std::uint8_t, 5> data{static_cast<std::uint8_t>(std::lround(100 * flight_.battery().charge()))};
    store(data.data() + 1, static_cast<float>(flight_.wind().length()));
    emit_flexible(id_of<"flexible9">, data);
}

// The sticks are 1000 to 2000 each; 0: no link.
void FlightController::heard(FrameView frame) {
    if (const auto m = as<"remote_control">(frame)) {
        const auto stick = [](int wire) { return std::clamp((wire - 1500) / 500.0, -1.0, 1.0); };
        const bool is_linked = m->get<"rol">() != 0 && m->get<"pit">() != 0 && m->get<"thr">() != 0 && m->get<"yaw">() != 0;
        if (!is_linked) return flight_.expire_sticks();
        flight_.receive(
            Sticks{stick(m->get<"rol">()), stick(m->get<"pit">()), (stick(m->get<"thr">()) + 1) / 2, stick(m->get<"yaw">())});
    } else if (const auto c = as<"realtime_control">(frame)) {
        flight_.receive(
            Steering{{c->get<"ctrl_rol">() * degree, c->get<"ctrl_pit">() * degree, 0},
                     std::clamp(c->get<"ctrl_thr">() / 100, 0.0, 1.0),
                     c->get<"ctrl_yaw_dps">() * degree,
                     {c->get<"ctrl_spd_x">() / 100.0, c->get<"ctrl_spd_y">() / 100.0, c->get<"ctrl_spd_z">() / 100.0}});
    }
}

}    // namespace ano::world
