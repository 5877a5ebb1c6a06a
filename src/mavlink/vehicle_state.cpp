#include <mavlink/vehicle_state.hpp>

#include <ano/messages.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace anogate::mavlink {
namespace {

constexpr double radian = std::numbers::pi / 180, metre = 0.01;

}    // namespace

Angles angles_of(const ano::Rotation& q) noexcept {
    const auto [w, x, y, z] = q;
    return {std::atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), std::asin(std::clamp(2 * (w * y - z * x), -1.0, 1.0)),
            std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))};
}

double VehicleState::number(std::string_view field) const noexcept {
    const ano::Field* const found = reading_->field(field);
    return found != nullptr ? reading_->number(*found) : std::numeric_limits<double>::quiet_NaN();
}

Vector VehicleState::of_vehicle(const char* x, const char* y, const char* z, double factor) const noexcept {
    return {factor * number(x), -factor * number(y), -factor * number(z)};
}

void VehicleState::receive(const ano::Reading& reading, ano::TimePoint now) noexcept {
    if (!reading) return;
    reading_ = &reading;
    ++frames_[reading.message()->id];
    switch (reading.message()->id) {
    case ano::id_of<"inertial">:
        acceleration.set(of_vehicle("acc_x", "acc_y", "acc_z", metre), now);
        rates.set(of_vehicle("gyr_x", "gyr_y", "gyr_z", radian), now);
        break;
    case ano::id_of<"compass">:
        magnetic_field.set(of_vehicle("mag_x", "mag_y", "mag_z", 1), now);
        temperature.set(number("tmp"), now);
        break;
    case ano::id_of<"euler">:
    case ano::id_of<"quaternion">: on_attitude(now); break;
    case ano::id_of<"altitude">:
        altitudes.set({metre * number("alt_bar"), metre * number("alt_add"), metre * number("alt_fu")}, now);
        break;
    case ano::id_of<"mode">: on_mode(now); break;
    case ano::id_of<"velocity">: velocity.set(of_vehicle("speed_x", "speed_y", "speed_z", metre), now); break;
    case ano::id_of<"position">: on_position(now); break;
    case ano::id_of<"wind">: wind.set({metre * number("wind_x"), -metre * number("wind_y"), 0}, now); break;
    case ano::id_of<"target_attitude">:
        target_attitude.set(
            angles_of(ned_of_frd(ano::rotation_of_euler(number("tar_rol"), number("tar_pit"), number("tar_yaw"), signs_))), now);
        break;
    case ano::id_of<"target_velocity">:
        target_velocity.set(of_vehicle("tar_speed_x", "tar_speed_y", "tar_speed_z", metre), now);
        break;
    case ano::id_of<"return_home">: way_home.set({std::fmod(360 - number("r_a"), 360), number("r_d")}, now); break;
    case ano::id_of<"power">: power.set({number("voltage"), number("current")}, now); break;
    case ano::id_of<"module_status">:
        modules.set({static_cast<std::uint8_t>(number("sta_g_vel")), static_cast<std::uint8_t>(number("sta_g_pos")),
                     static_cast<std::uint8_t>(number("sta_gps")), static_cast<std::uint8_t>(number("sta_alt_add"))},
                    now);
        break;
    case ano::id_of<"pwm">: on_outputs(now); break;
    case ano::id_of<"attitude_control">: throttle.set(number("ctrl_thr") / 100, now); break;
    case ano::id_of<"gps">: on_fix(now); break;
    case ano::id_of<"ranging">: on_ranging(now); break;
    case ano::id_of<"remote_control">: on_sticks(now); break;
    case ano::id_of<"raw_flow">:
        flow.set({static_cast<std::uint8_t>(number("qua")), number("dx"), -number("dy"), {}}, now);
        break;
    case ano::id_of<"optical_flow">: on_flow(now); break;
    default: break;
    }
    reading_ = nullptr;
}

void VehicleState::on_attitude(ano::TimePoint now) noexcept {
    if (reading_->message()->id == ano::id_of<"quaternion">) {
        const auto q = ano::rotation_of_quaternion(number("v0"), number("v1"), number("v2"), number("v3"));
        if (q) by_quaternion_.set(ned_of_frd(*q), now);
    } else {
        by_euler_.set(ned_of_frd(ano::rotation_of_euler(number("rol"), number("pit"), number("yaw"), signs_)), now);
    }
}

void VehicleState::on_mode(ano::TimePoint now) noexcept {
    constexpr double airborne = 2;
    const auto byte = [this](const char* name) { return static_cast<std::uint8_t>(number(name)); };
    const FlightMode next{byte("mode"),
                          static_cast<FlightMode::Safety>(std::min(number("sflag"), airborne)),
                          {byte("cid"), byte("cmd0"), byte("cmd1")}};
    if (!next.is_armed()) home_is_fixed_ = false;
    mode.set(next, now);
    if (next.is_armed() && home_) home_is_fixed_ = true;
}

void VehicleState::on_fix(ano::TimePoint now) noexcept {
    constexpr double per_degree = 1e7, millimetre = 0.001;
    fix.set({static_cast<std::uint8_t>(number("fix_sta")),
             static_cast<std::uint8_t>(number("s_num")),
             static_cast<std::int32_t>(std::lround(per_degree * number("lat"))),
             static_cast<std::int32_t>(std::lround(per_degree * number("lng"))),
             metre * number("alt_gps"),
             {metre * number("n_spe"), metre * number("e_spe"), metre * number("d_spe")},
             number("pdop"),
             millimetre * number("sacc"),
             millimetre * number("vacc")},
            now);
    find_home(now);
}

void VehicleState::on_position(ano::TimePoint now) noexcept {
    const Vector there = of_vehicle("pos_x", "pos_y", "pos_z", metre);
    if (!std::isnan(there.z)) height.set(-there.z, now);
    position.set({there.x, there.y, std::isnan(there.z) ? 0 : there.z}, now);
}

// Where the vehicle is, less its way from the take-off point.
void VehicleState::find_home(ano::TimePoint now) noexcept {
    const Fix* const here = fix.at(now);
    if (home_is_fixed_ || !here->is_valid()) return;
    const FlightMode* const state = mode.at(now);
    const Vector* const way = position.at(now);
    if (state == nullptr || (state->is_armed() && way == nullptr)) return;
    // On the ground the position may still be that from the take-off point before.
    const Vector from_home = state->is_armed() ? *way : Vector{};
    constexpr double unit = 1e-7;
    const double east = metres_per_degree * std::cos(here->lat * unit * radian);
    home_ = Home{static_cast<std::int32_t>(std::lround(here->lat - from_home.x / metres_per_degree / unit)),
                 static_cast<std::int32_t>(std::lround(here->lng - from_home.y / east / unit)), here->altitude + from_home.z};
    home_is_fixed_ = state->is_armed();
}

void VehicleState::on_outputs(ano::TimePoint now) noexcept {
    constexpr std::array names{"pwm1", "pwm2", "pwm3", "pwm4", "pwm5", "pwm6", "pwm7", "pwm8"};
    Outputs next;
    for (; next.count < names.size() && reading_->field(names[next.count]) != nullptr; ++next.count)
        next.percent[next.count] = number(names[next.count]);
    outputs.set(next, now);
}

// The layout with one distance at an angle has no fixed direction.
void VehicleState::on_ranging(ano::TimePoint now) noexcept {
    constexpr double full_circle = 360, millimetre = 0.001;
    if (reading_->message()->is_base()) {
        const double distance = millimetre * number("dist");
        if (distance >= 0) distances[static_cast<std::size_t>(number("type")) % sides].set(distance, now);
        return;
    }
    if (!reading_->message()->ends_in_list()) return;
    std::array<std::uint16_t, scan_sectors> sectors;
    sectors.fill(nothing_measured);
    const auto fields = reading_->element_fields();
    for (std::size_t i = 0; i < reading_->element_count(); ++i) {
        const double angle = std::get<double>(reading_->element(i, fields[0]));
        const auto distance = static_cast<std::uint16_t>(std::get<std::int64_t>(reading_->element(i, fields[1])));
        if (distance == 0 || distance == nothing_measured) continue;
        const auto sector = static_cast<std::size_t>(std::lround(angle * scan_sectors / full_circle)) % scan_sectors;
        sectors[sector] = std::min(sectors[sector], distance);
    }
    scan.set(sectors, now);
}

void VehicleState::on_flow(ano::TimePoint now) noexcept {
    if (number("state") != 1) return;
    const double mode_of_sensor = number("mode");
    Flow next{static_cast<std::uint8_t>(number("quality")), 0, 0, {}};
    if (mode_of_sensor == 0) {
        next.pixels_x = number("dx_0");
        next.pixels_y = -number("dy_0");
    } else {
        const bool is_fused = mode_of_sensor == 2;
        next.speed = {metre * number(is_fused ? "dx_fix" : "dx_1"), -metre * number(is_fused ? "dy_fix" : "dy_1"), 0};
    }
    flow.set(next, now);
}

void VehicleState::on_sticks(ano::TimePoint now) noexcept {
    constexpr std::array names{"rol", "pit", "thr", "yaw", "aux1", "aux2", "aux3", "aux4", "aux5", "aux6"};
    std::array<std::uint16_t, names.size()> channels{};
    for (std::size_t i = 0; i < names.size(); ++i) channels[i] = static_cast<std::uint16_t>(std::max(0.0, number(names[i])));
    sticks.set(channels, now);
}

}    // namespace anogate::mavlink
