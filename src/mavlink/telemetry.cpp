#include <mavlink/telemetry.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace anogate::mavlink {
namespace {

using Context = TelemetryContext;
using Made = std::optional<Payload>;

constexpr double degrees = 180 / std::numbers::pi;
constexpr float not_known = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint16_t unknown_u16 = 0xFFFF;

std::uint32_t boot_ms(const Context& c) noexcept { return static_cast<std::uint32_t>(c.since_start_us / 1000); }

// 0 to 360.
double compass_degrees(double radians) noexcept {
    const double angle = std::fmod(degrees * radians, 360);
    return angle < 0 ? angle + 360 : angle;
}

Made heartbeat(const Context& c) {
    enum : unsigned { custom = 1, automatic = 4, guided = 8, stabilized = 16, manual = 64, armed = 128 };
    constexpr std::uint8_t starting = 0, standby = 3, active = 4;
    const FlightMode* const mode = c.state.mode.at(c.now);
    const auto activity = activity_of(c);
    Draft<"HEARTBEAT"> draft;
    draft.set<"type">(c.identity.type).set<"autopilot">(number_of(c.identity.autopilot)).set<"mavlink_version">(3);
    if (mode == nullptr || !activity) return draft.set<"system_status">(starting);
    unsigned base{custom | stabilized};
    if (mode->is_armed()) base |= armed;
    if (*activity <= Activity::position) base |= manual;
    else base |= *activity == Activity::programmed ? guided : guided | automatic;
    draft.set<"base_mode">(base).set<"custom_mode">(custom_mode(c.identity.autopilot, *activity));
    return draft.set<"system_status">(mode->is_armed() ? active : standby);
}

Made sys_status(const Context& c) {
    enum : std::uint32_t {
        gyro = 1,
        accelerometer = 2,
        compass = 4,
        barometer = 8,
        gps = 0x20,
        flow = 0x40,
        motors = 0x8000,
        receiver = 0x10000,
        battery = 0x2000000
    };
    constexpr std::uint8_t normal = 2;
    const VehicleState& s = c.state;
    std::uint32_t present = 0;
    const auto add = [&](std::uint32_t bit, bool is_there) { present |= is_there ? bit : 0; };
    add(gyro | accelerometer, s.rates.at(c.now) != nullptr);
    add(compass, s.magnetic_field.at(c.now) != nullptr);
    add(barometer, s.altitudes.at(c.now) != nullptr);
    add(gps, s.fix.at(c.now) != nullptr);
    add(flow, s.flow.at(c.now) != nullptr);
    add(motors, s.outputs.at(c.now) != nullptr);
    add(receiver, s.sticks.at(c.now) != nullptr);
    const Power* const power = s.power.at(c.now);
    add(battery, power != nullptr);
    std::uint32_t health = present;
    if (const Modules* const modules = s.modules.at(c.now); modules != nullptr && modules->gps < normal)
        health &= ~std::uint32_t{gps};
    Draft<"SYS_STATUS"> draft;
    draft.set<"onboard_control_sensors_present">(present).set<"onboard_control_sensors_enabled">(present);
    draft.set<"onboard_control_sensors_health">(health).set<"battery_remaining">(-1);
    draft.set<"voltage_battery">(power != nullptr ? limited<std::uint16_t>(1000 * power->voltage) : unknown_u16);
    draft.set<"current_battery">(power != nullptr ? limited<std::int16_t>(100 * power->current) : std::int16_t{-1});
    const std::uint64_t all = c.link.received + c.link.lost;
    draft.set<"drop_rate_comm">(all == 0 ? 0.0 : 10'000.0 * static_cast<double>(c.link.lost) / static_cast<double>(all));
    return draft.set<"errors_comm">(std::min<std::uint64_t>(c.link.bad, unknown_u16));
}

Made battery_status(const Context& c) {
    const Power* const power = c.state.power.at(c.now);
    if (power == nullptr) return std::nullopt;
    constexpr std::size_t cells_here = 10, more_cells = 4;
    const std::size_t cells = std::clamp<std::size_t>(c.identity.cells, 1, cells_here + more_cells);
    const auto voltage = limited<std::uint16_t>(1000 * power->voltage / static_cast<double>(cells));
    Draft<"BATTERY_STATUS"> draft;
    for (std::size_t i = 0; i < cells_here; ++i) draft.set<"voltages">(i < cells ? voltage : unknown_u16, i);
    for (std::size_t i = 0; i < more_cells; ++i)
        draft.set<"voltages_ext">(cells_here + i < cells ? voltage : std::uint16_t{0}, i);
    draft.set<"temperature">(std::numeric_limits<std::int16_t>::max()).set<"current_battery">(100 * power->current);
    return draft.set<"current_consumed">(-1).set<"energy_consumed">(-1).set<"battery_remaining">(-1);
}

Made attitude(const Context& c) {
    const ano::Rotation* const q = c.state.attitude(c.now);
    if (q == nullptr) return std::nullopt;
    const Angles angles = angles_of(*q);
    const Vector* const rates = c.state.rates.at(c.now);
    const Vector turning = rates != nullptr ? *rates : Vector{};
    Draft<"ATTITUDE"> draft;
    draft.set<"time_boot_ms">(boot_ms(c)).set<"roll">(angles.roll).set<"pitch">(angles.pitch).set<"yaw">(angles.yaw);
    return draft.set<"rollspeed">(turning.x).set<"pitchspeed">(turning.y).set<"yawspeed">(turning.z);
}

Made attitude_quaternion(const Context& c) {
    const ano::Rotation* const q = c.state.attitude(c.now);
    if (q == nullptr) return std::nullopt;
    const Vector* const rates = c.state.rates.at(c.now);
    const Vector turning = rates != nullptr ? *rates : Vector{};
    Draft<"ATTITUDE_QUATERNION"> draft;
    draft.set<"time_boot_ms">(boot_ms(c)).set<"q1">(q->w).set<"q2">(q->x).set<"q3">(q->y).set<"q4">(q->z);
    return draft.set<"rollspeed">(turning.x).set<"pitchspeed">(turning.y).set<"yawspeed">(turning.z);
}

std::uint8_t fix_type(const Fix& fix) noexcept {
    constexpr std::uint8_t none = 1, two = 2, three = 3;
    if (!fix.is_valid()) return none;
    return fix.fix == 2 ? two : three;
}

Made gps_raw_int(const Context& c) {
    const Fix* const fix = c.state.fix.at(c.now);
    if (fix == nullptr) return std::nullopt;
    constexpr double unreliable = 200;
    const double speed = std::hypot(fix->velocity.x, fix->velocity.y),
                 course = compass_degrees(std::atan2(fix->velocity.y, fix->velocity.x));
    Draft<"GPS_RAW_INT"> draft;
    draft.set<"time_usec">(c.since_start_us).set<"fix_type">(fix_type(*fix)).set<"lat">(fix->lat).set<"lon">(fix->lng);
    draft.set<"alt">(1000 * fix->altitude)
        .set<"eph">(fix->dilution < unreliable ? limited<std::uint16_t>(100 * fix->dilution) : unknown_u16);
    draft.set<"epv">(unknown_u16).set<"vel">(100 * speed).set<"cog">(std::fmod(std::round(100 * course), 36'000));
    draft.set<"satellites_visible">(fix->satellites).set<"vel_acc">(1000 * fix->speed_accuracy);
    return draft.set<"v_acc">(1000 * fix->height_accuracy);
}

// By the estimate of the device, else by the receiver.
Vector velocity_of(const Context& c, const Fix& fix) noexcept {
    const Vector* const velocity = c.state.velocity.at(c.now);
    return velocity != nullptr ? *velocity : fix.velocity;
}

std::optional<double> height_of(const Context& c) noexcept {
    if (const double* const height = c.state.height.at(c.now)) return *height;
    if (const Altitudes* const altitudes = c.state.altitudes.at(c.now)) return altitudes->fused;
    return std::nullopt;
}

std::uint16_t heading_of(const Context& c) noexcept {
    const ano::Rotation* const q = c.state.attitude(c.now);
    if (q == nullptr) return unknown_u16;
    return static_cast<std::uint16_t>(std::fmod(std::round(100 * compass_degrees(angles_of(*q).yaw)), 36'000));
}

Made global_position_int(const Context& c) {
    const Fix* const fix = c.state.fix.at(c.now);
    if (fix == nullptr || !fix->is_valid()) return std::nullopt;
    const Vector velocity = velocity_of(c, *fix);
    Draft<"GLOBAL_POSITION_INT"> draft;
    draft.set<"time_boot_ms">(boot_ms(c)).set<"lat">(fix->lat).set<"lon">(fix->lng).set<"alt">(1000 * fix->altitude);
    draft.set<"relative_alt">(1000 * height_of(c).value_or(0)).set<"hdg">(heading_of(c));
    return draft.set<"vx">(100 * velocity.x).set<"vy">(100 * velocity.y).set<"vz">(100 * velocity.z);
}

Made local_position_ned(const Context& c) {
    const Vector* const position = c.state.position.at(c.now);
    if (position == nullptr) return std::nullopt;
    const Vector* const known = c.state.velocity.at(c.now);
    const Vector velocity = known != nullptr ? *known : Vector{};
    Draft<"LOCAL_POSITION_NED"> draft;
    draft.set<"time_boot_ms">(boot_ms(c)).set<"x">(position->x).set<"y">(position->y).set<"z">(position->z);
    return draft.set<"vx">(velocity.x).set<"vy">(velocity.y).set<"vz">(velocity.z);
}

double throttle_of(const Context& c) noexcept {
    if (const double* const throttle = c.state.throttle.at(c.now)) return *throttle;
    const Outputs* const outputs = c.state.outputs.at(c.now);
    if (outputs == nullptr || outputs->count == 0) return 0;
    double sum = 0;
    for (std::size_t i = 0; i < outputs->count; ++i) sum += outputs->percent[i];
    return sum / static_cast<double>(outputs->count);
}

Made vfr_hud(const Context& c) {
    const Vector* const velocity = c.state.velocity.at(c.now);
    const Fix* const fix = c.state.fix.at(c.now);
    const auto height = height_of(c);
    if (velocity == nullptr && !height) return std::nullopt;
    const std::uint16_t heading = heading_of(c);
    Draft<"VFR_HUD"> draft;
    draft.set<"airspeed">(not_known).set<"groundspeed">(velocity != nullptr ? std::hypot(velocity->x, velocity->y) : 0.0);
    draft.set<"heading">(heading == unknown_u16 ? std::int16_t{-1} : static_cast<std::int16_t>(heading / 100))
        .set<"throttle">(throttle_of(c));
    draft.set<"alt">(fix != nullptr && fix->is_valid() ? fix->altitude : height.value_or(0));
    return draft.set<"climb">(velocity != nullptr ? -velocity->z : 0.0);
}

Made altitude(const Context& c) {
    constexpr float unknown_terrain = -1000, unknown_clearance = -1;
    const Altitudes* const altitudes = c.state.altitudes.at(c.now);
    const auto height = height_of(c);
    if (altitudes == nullptr && !height) return std::nullopt;
    const Fix* const fix = c.state.fix.at(c.now);
    const double* const below = c.state.distances[static_cast<std::size_t>(Side::down)].at(c.now);
    Draft<"ALTITUDE"> draft;
    draft.set<"time_usec">(c.since_start_us).set<"altitude_monotonic">(altitudes != nullptr ? altitudes->barometric : not_known);
    draft.set<"altitude_amsl">(fix != nullptr && fix->is_valid() ? fix->altitude : not_known);
    draft.set<"altitude_local">(altitudes != nullptr ? altitudes->fused : *height)
        .set<"altitude_relative">(height.value_or(not_known));
    return draft.set<"altitude_terrain">(unknown_terrain).set<"bottom_clearance">(below != nullptr ? *below : unknown_clearance);
}

Made home_position(const Context& c) {
    const auto& home = c.state.home();
    if (!home) return std::nullopt;
    Draft<"HOME_POSITION"> draft;
    draft.set<"latitude">(home->lat).set<"longitude">(home->lng).set<"altitude">(1000 * home->altitude).set<"q">(1.0F);
    for (std::size_t i = 1; i < 4; ++i) draft.set<"q">(0.0F, i);
    draft.set<"approach_x">(not_known).set<"approach_y">(not_known).set<"approach_z">(not_known);
    return draft.set<"time_usec">(c.since_start_us);
}

Made extended_sys_state(const Context& c) {
    constexpr std::uint8_t on_ground = 1, in_air = 2, taking_off = 3, landing = 4;
    const FlightMode* const mode = c.state.mode.at(c.now);
    if (mode == nullptr) return std::nullopt;
    const auto activity = activity_of(c);
    std::uint8_t landed = mode->safety == FlightMode::Safety::airborne ? in_air : on_ground;
    if (mode->is_armed() && activity == Activity::take_off) landed = taking_off;
    if (landed == in_air && activity == Activity::land) landed = landing;
    return Draft<"EXTENDED_SYS_STATE">{}.set<"landed_state">(landed);
}

Made rc_channels(const Context& c) {
    const auto* const sticks = c.state.sticks.at(c.now);
    if (sticks == nullptr) return std::nullopt;
    Draft<"RC_CHANNELS"> draft;
    std::array<std::uint16_t, 18> all;
    all.fill(unknown_u16);
    for (std::size_t i = 0; i < sticks->size(); ++i) all[i] = (*sticks)[i] != 0 ? (*sticks)[i] : unknown_u16;
    draft.set<"time_boot_ms">(boot_ms(c)).set<"chancount">(sticks->size()).set<"rssi">(0xFF);
    draft.set<"chan1_raw">(all[0]).set<"chan2_raw">(all[1]).set<"chan3_raw">(all[2]).set<"chan4_raw">(all[3]);
    draft.set<"chan5_raw">(all[4]).set<"chan6_raw">(all[5]).set<"chan7_raw">(all[6]).set<"chan8_raw">(all[7]);
    draft.set<"chan9_raw">(all[8]).set<"chan10_raw">(all[9]).set<"chan11_raw">(unknown_u16).set<"chan12_raw">(unknown_u16);
    draft.set<"chan13_raw">(unknown_u16).set<"chan14_raw">(unknown_u16).set<"chan15_raw">(unknown_u16);
    return draft.set<"chan16_raw">(unknown_u16).set<"chan17_raw">(unknown_u16).set<"chan18_raw">(unknown_u16);
}

// 0 to 100 % as pulses of 1000 to 2000 µs.
Made servo_output_raw(const Context& c) {
    const Outputs* const outputs = c.state.outputs.at(c.now);
    if (outputs == nullptr) return std::nullopt;
    std::array<std::uint16_t, 8> pulses{};
    for (std::size_t i = 0; i < outputs->count; ++i) pulses[i] = limited<std::uint16_t>(1000 + 10 * outputs->percent[i]);
    Draft<"SERVO_OUTPUT_RAW"> draft;
    draft.set<"time_usec">(static_cast<std::uint32_t>(c.since_start_us));
    draft.set<"servo1_raw">(pulses[0]).set<"servo2_raw">(pulses[1]).set<"servo3_raw">(pulses[2]).set<"servo4_raw">(pulses[3]);
    return draft.set<"servo5_raw">(pulses[4]).set<"servo6_raw">(pulses[5]).set<"servo7_raw">(pulses[6]).set<"servo8_raw">(
        pulses[7]);
}

template <class D>
Made inertial(const Context& c, D draft) {
    const Vector *const acceleration = c.state.acceleration.at(c.now), *const rates = c.state.rates.at(c.now);
    if (acceleration == nullptr || rates == nullptr) return std::nullopt;
    const Vector* const known = c.state.magnetic_field.at(c.now);
    const double* const temperature = c.state.temperature.at(c.now);
    const Vector magnetic = known != nullptr ? *known : Vector{};
    constexpr double milli_g = 1000 / 9.80665, milli = 1000;
    draft.template set<"xacc">(milli_g * acceleration->x)
        .template set<"yacc">(milli_g * acceleration->y)
        .template set<"zacc">(milli_g * acceleration->z);
    draft.template set<"xgyro">(milli * rates->x).template set<"ygyro">(milli * rates->y).template set<"zgyro">(milli * rates->z);
    draft.template set<"xmag">(magnetic.x).template set<"ymag">(magnetic.y).template set<"zmag">(magnetic.z);
    // Hundredths of a degree; 0: unknown, so that 0 °C is 0.01.
    if (temperature != nullptr) draft.template set<"temperature">(*temperature == 0 ? 1.0 : 100 * *temperature);
    return draft;
}

Made scaled_imu(const Context& c) {
    Draft<"SCALED_IMU"> draft;
    return inertial(c, draft.set<"time_boot_ms">(boot_ms(c)));
}

Made raw_imu(const Context& c) {
    Draft<"RAW_IMU"> draft;
    return inertial(c, draft.set<"time_usec">(c.since_start_us));
}

template <Side side>
Made distance_sensor(const Context& c) {
    constexpr std::uint8_t orientations[sides] = {25, 0, 4,
                                                  6,  2, 24};    // MAV_SENSOR_ROTATION: down, forward, back, left, right, up
    constexpr std::uint8_t unknown_type = 4, unknown_covariance = 0xFF;
    constexpr auto number = static_cast<std::uint8_t>(side);
    const double* const distance = c.state.distances[number].at(c.now);
    if (distance == nullptr) return std::nullopt;
    Draft<"DISTANCE_SENSOR"> draft;
    draft.set<"time_boot_ms">(boot_ms(c)).set<"max_distance">(unknown_u16).set<"current_distance">(100 * *distance);
    draft.set<"type">(unknown_type).set<"id">(number).set<"orientation">(orientations[number]);
    return draft.set<"covariance">(unknown_covariance);
}

Made obstacle_distance(const Context& c) {
    constexpr std::uint8_t unknown_type = 4, body_frd = 12, step = 360 / scan_sectors;
    constexpr std::uint16_t least = 1, most = 65'533;    // above it: no obstacle, nothing measured
    const auto* const scan = c.state.scan.at(c.now);
    if (scan == nullptr) return std::nullopt;
    Draft<"OBSTACLE_DISTANCE"> draft;
    for (std::size_t i = 0; i < scan->size(); ++i) draft.set<"distances">((*scan)[i], i);
    draft.set<"time_usec">(c.since_start_us).set<"sensor_type">(unknown_type).set<"increment">(step).set<"min_distance">(least);
    return draft.set<"max_distance">(most).set<"frame">(body_frd);
}

Made optical_flow(const Context& c) {
    constexpr double tenths = 10;
    constexpr float unknown_distance = -1;
    const Flow* const flow = c.state.flow.at(c.now);
    if (flow == nullptr) return std::nullopt;
    const double* const below = c.state.distances[static_cast<std::size_t>(Side::down)].at(c.now);
    Draft<"OPTICAL_FLOW"> draft;
    draft.set<"time_usec">(c.since_start_us).set<"flow_x">(tenths * flow->pixels_x).set<"flow_y">(tenths * flow->pixels_y);
    draft.set<"flow_comp_m_x">(flow->speed.x).set<"flow_comp_m_y">(flow->speed.y).set<"quality">(flow->quality);
    return draft.set<"ground_distance">(below != nullptr ? *below : unknown_distance);
}

Made wind_cov(const Context& c) {
    const Vector* const wind = c.state.wind.at(c.now);
    if (wind == nullptr) return std::nullopt;
    const Fix* const fix = c.state.fix.at(c.now);
    Draft<"WIND_COV"> draft;
    draft.set<"time_usec">(c.since_start_us).set<"wind_x">(wind->x).set<"wind_y">(wind->y).set<"wind_z">(not_known);
    draft.set<"var_horiz">(not_known).set<"var_vert">(not_known).set<"wind_alt">(fix != nullptr && fix->is_valid() ? fix->altitude
                                                                                                                   : not_known);
    return draft.set<"horiz_accuracy">(not_known).set<"vert_accuracy">(not_known);
}

Made nav_controller_output(const Context& c) {
    const Angles* const attitude = c.state.target_attitude.at(c.now);
    if (attitude == nullptr) return std::nullopt;
    const WayHome* const home = c.state.way_home.at(c.now);
    const Vector *const wanted = c.state.target_velocity.at(c.now), *const velocity = c.state.velocity.at(c.now);
    Draft<"NAV_CONTROLLER_OUTPUT"> draft;
    draft.set<"nav_roll">(degrees * attitude->roll).set<"nav_pitch">(degrees * attitude->pitch);
    draft.set<"nav_bearing">(compass_degrees(attitude->yaw));
    if (home != nullptr) draft.set<"target_bearing">(home->bearing).set<"wp_dist">(home->distance);
    if (wanted != nullptr && velocity != nullptr)
        draft.set<"aspd_error">(std::hypot(wanted->x, wanted->y) - std::hypot(velocity->x, velocity->y));
    return draft;
}

Made link_node_status(const Context& c) {
    const auto limit = [](std::uint64_t count) { return std::min<std::uint64_t>(count, unknown_u16); };
    Draft<"LINK_NODE_STATUS"> draft;
    draft.set<"timestamp">(c.since_start_us / 1000).set<"tx_rate">(c.link.sent_rate).set<"rx_rate">(c.link.received_rate);
    draft.set<"rx_parse_err">(limit(c.link.bad)).set<"messages_sent">(c.link.sent).set<"messages_received">(c.link.received);
    return draft.set<"messages_lost">(c.link.lost);
}

Made autopilot_version(const Context& c) {
    enum : std::uint64_t {
        bytewise = 16,
        command_int = 8,
        mission_int = 4,
        attitude_target = 64,
        velocity_target = 128,
        version_2 = 8192
    };
    std::uint64_t capabilities = bytewise | command_int | version_2;
    if (c.identity.has_missions) capabilities |= mission_int;
    if (c.identity.has_attitude_target) capabilities |= attitude_target;
    if (c.identity.has_velocity_target) capabilities |= velocity_target;
    // QGroundControl warns of PX4 before 1.4.1; the version of the device is in board_version and flight_custom_version.
    constexpr std::uint32_t official = 255, as_px4 = 1u << 24 | 14u << 16 | official,
                            as_ardupilot = 4u << 24 | 5u << 16 | official;
    const auto device = static_cast<std::uint32_t>(c.identity.software / 100 << 24 | c.identity.software % 100 << 16);
    Draft<"AUTOPILOT_VERSION"> draft;
    draft.set<"capabilities">(capabilities).set<"board_version">(c.identity.hardware);
    draft.set<"flight_custom_version">(c.identity.software & 0xFF, 0).set<"flight_custom_version">(c.identity.software >> 8, 1);
    if (c.identity.autopilot == Autopilot::px4) return draft.set<"flight_sw_version">(as_px4);
    return draft.set<"flight_sw_version">(c.identity.autopilot == Autopilot::ardupilot ? as_ardupilot : device);
}

Made system_time(const Context& c) {
    return Draft<"SYSTEM_TIME">{}.set<"time_unix_usec">(c.unix_us).set<"time_boot_ms">(boot_ms(c));
}

Made protocol_version(const Context&) {
    constexpr std::uint16_t version_1 = 100, version_2 = 200;
    return Draft<"PROTOCOL_VERSION">{}.set<"version">(version_2).set<"min_version">(version_1).set<"max_version">(version_2);
}

// A rate of 0: only on request.
constexpr TelemetryRow message_rows[] = {
    {id_of<"HEARTBEAT">, 1, Stream::none, heartbeat},
    {id_of<"SYS_STATUS">, 2, Stream::extended_status, sys_status},
    {id_of<"SYSTEM_TIME">, 1, Stream::extra3, system_time},
    {id_of<"LINK_NODE_STATUS">, 1, Stream::extra3, link_node_status},
    {id_of<"GPS_RAW_INT">, 5, Stream::extended_status, gps_raw_int, {0x30}},
    {id_of<"SCALED_IMU">, 0, Stream::raw_sensors, scaled_imu, {0x01}},
    {id_of<"RAW_IMU">, 10, Stream::raw_sensors, raw_imu, {0x01}},
    {id_of<"ATTITUDE">, 50, Stream::extra1, attitude, {0x03, 0x04}},
    {id_of<"ATTITUDE_QUATERNION">, 10, Stream::extra1, attitude_quaternion, {0x03, 0x04}},
    {id_of<"LOCAL_POSITION_NED">, 10, Stream::position, local_position_ned, {0x08, 0x07}},
    {id_of<"GLOBAL_POSITION_INT">, 10, Stream::position, global_position_int, {0x30, 0x07}},
    {id_of<"SERVO_OUTPUT_RAW">, 5, Stream::raw_controller, servo_output_raw, {0x20}},
    {id_of<"NAV_CONTROLLER_OUTPUT">, 2, Stream::extended_status, nav_controller_output, {0x0A}},
    {id_of<"RC_CHANNELS">, 5, Stream::rc_channels, rc_channels, {0x40}},
    {id_of<"VFR_HUD">, 10, Stream::extra2, vfr_hud, {0x07, 0x05}},
    {id_of<"OPTICAL_FLOW">, 10, Stream::extra3, optical_flow, {0x51, 0x31}},
    {id_of<"DISTANCE_SENSOR">, 10, Stream::extra3, distance_sensor<Side::down>, {0x34}},
    {id_of<"DISTANCE_SENSOR">, 10, Stream::extra3, distance_sensor<Side::forward>, {0x34}},
    {id_of<"DISTANCE_SENSOR">, 10, Stream::extra3, distance_sensor<Side::back>, {0x34}},
    {id_of<"DISTANCE_SENSOR">, 10, Stream::extra3, distance_sensor<Side::left>, {0x34}},
    {id_of<"DISTANCE_SENSOR">, 10, Stream::extra3, distance_sensor<Side::right>, {0x34}},
    {id_of<"DISTANCE_SENSOR">, 10, Stream::extra3, distance_sensor<Side::up>, {0x34}},
    {id_of<"ALTITUDE">, 10, Stream::position, altitude, {0x05, 0x08}},
    {id_of<"BATTERY_STATUS">, 1, Stream::extended_status, battery_status},
    {id_of<"AUTOPILOT_VERSION">, 0, Stream::none, autopilot_version},
    {id_of<"WIND_COV">, 1, Stream::extra3, wind_cov, {0x09}},
    {id_of<"HOME_POSITION">, 1, Stream::extended_status, home_position},
    {id_of<"EXTENDED_SYS_STATE">, 5, Stream::extended_status, extended_sys_state},
    {id_of<"PROTOCOL_VERSION">, 0, Stream::none, protocol_version},
    {id_of<"OBSTACLE_DISTANCE">, 10, Stream::extra3, obstacle_distance, {0x34}},
};

// The longest beginning of `text` that has whole characters and at most `size` bytes.
std::string_view whole_characters(std::string_view text, std::size_t size) noexcept {
    if (text.size() <= size) return text;
    while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0u) == 0x80u) --size;
    return text.substr(0, size);
}

}    // namespace

std::optional<Activity> activity_of(const Context& context) noexcept {
    constexpr std::uint8_t last_mode = 3;
    const FlightMode* const mode = context.state.mode.at(context.now);
    if (mode == nullptr || mode->mode > last_mode) return std::nullopt;
    for (const ActivityCommand& command : context.identity.activities)
        if (mode->is_armed() && command.cid == mode->command) return command.activity;
    return static_cast<Activity>(mode->mode);
}

std::span<const TelemetryRow> telemetry_rows() noexcept { return message_rows; }

const TelemetryRow* find_telemetry(std::uint32_t id) noexcept {
    for (const TelemetryRow& row : message_rows)
        if (row.id == id) return &row;
    return nullptr;
}

std::vector<Payload> status_texts(Severity severity, std::string_view text, std::uint16_t id) {
    constexpr std::size_t part_size = 50;
    std::vector<Payload> parts;
    const bool is_whole = text.size() <= part_size;
    do {
        const std::string_view part = whole_characters(text, part_size);
        Draft<"STATUSTEXT"> draft;
        draft.set<"severity">(static_cast<std::uint8_t>(severity)).set_text<"text">(part);
        if (!is_whole) draft.set<"id">(id).set<"chunk_seq">(parts.size());
        parts.emplace_back(draft);
        text.remove_prefix(part.empty() ? text.size() : part.size());
        // A part that fills the field needs another one, which shows the end.
        if (text.empty() && !is_whole && part.size() == part_size)
            parts.emplace_back(Draft<"STATUSTEXT">{}
                                   .set<"severity">(static_cast<std::uint8_t>(severity))
                                   .set<"id">(id)
                                   .set<"chunk_seq">(parts.size()));
    } while (!text.empty() && parts.size() < 0xFF);
    return parts;
}

std::vector<Payload> named_values(const ano::Reading& reading, std::uint64_t since_start_us) {
    constexpr std::size_t name_size = 10, most = 58;
    std::vector<Payload> all;
    if (!reading) return all;
    std::uint16_t number = 0;
    for (const ano::Field& field : reading.fields()) {
        if (!ano::is_number(field.type)) continue;
        const std::string_view name = whole_characters(field.name, name_size);
        if (field.count == 1) {
            Draft<"NAMED_VALUE_FLOAT"> draft;
            draft.set<"time_boot_ms">(static_cast<std::uint32_t>(since_start_us / 1000)).set_text<"name">(name);
            all.emplace_back(draft.set<"value">(reading.number(field)));
            continue;
        }
        Draft<"DEBUG_FLOAT_ARRAY"> draft;
        draft.set<"time_usec">(since_start_us).set_text<"name">(name).set<"array_id">(number++);
        const ano::Bytes bytes = reading.bytes_of(field);
        for (std::size_t i = 0; i < std::min<std::size_t>(field.count, most); ++i)
            draft.set<"data">(ano::number_at(field, bytes.data() + i * ano::width(field.type)), i);
        all.emplace_back(draft);
    }
    return all;
}

}    // namespace anogate::mavlink
