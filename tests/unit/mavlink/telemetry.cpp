// Messages about a vehicle from frames of its device, with numbers that can be checked by hand.
#include <mavlink/telemetry.hpp>
#include <mavlink/telemetry_schedule.hpp>

#include <ano/typed.hpp>

#include <gtest/gtest.h>
#include <support/bytes.hpp>

#include <cmath>
#include <map>
#include <numbers>

namespace mavlink_telemetry_tests {
namespace {

using namespace anogate::mavlink;
using namespace std::chrono_literals;
using ano::TimePoint;

constexpr double degree = std::numbers::pi / 180;
constexpr std::uint8_t fc = 0xDC;

class Telemetry : public testing::Test {
protected:
    template <class D>
    void receive(const D& draft) {
        std::array<std::uint8_t, 300> bytes{};
        const std::size_t size = draft.encode(bytes, fc, 0xFF);
        const auto frame = ano::frame_at(std::span{bytes}.first(size));
        ASSERT_TRUE(frame);
        state.receive(ano::read(*frame), now);
    }
    void mode(unsigned number, unsigned sflag, Cid cid = {0x10, 0, 4}) {
        ano::Draft<"mode"> draft;
        EXPECT_TRUE(draft.set<"mode">(number) && draft.set<"sflag">(sflag) && draft.set<"cid">(cid[0]) &&
                    draft.set<"cmd0">(cid[1]) && draft.set<"cmd1">(cid[2]));
        receive(draft);
    }
    void fix(double lat, double lng, double altitude_cm, int quality = 3) {
        ano::Draft<"gps"> draft;
        EXPECT_TRUE(draft.set<"fix_sta">(quality) && draft.set<"s_num">(14) && draft.set<"lng">(lng) && draft.set<"lat">(lat) &&
                    draft.set<"alt_gps">(altitude_cm) && draft.set<"n_spe">(30) && draft.set<"e_spe">(-40) &&
                    draft.set<"d_spe">(5) && draft.set<"pdop">(2) && draft.set<"sacc">(200) && draft.set<"vacc">(1500));
        receive(draft);
    }
    void position(int north_cm, int west_cm, int up_cm) {
        ano::Draft<"position"> draft;
        EXPECT_TRUE(draft.set<"pos_x">(north_cm) && draft.set<"pos_y">(west_cm) && draft.set<"pos_z">(up_cm));
        receive(draft);
    }
    void euler(double roll, double pitch, double yaw) {
        ano::Draft<"euler"> draft;
        EXPECT_TRUE(draft.set<"rol">(roll) && draft.set<"pit">(pitch) && draft.set<"yaw">(yaw));
        receive(draft);
    }
    template <ano::Name M>
    std::optional<View<M>> make() const {
        const auto made = find_telemetry(View<M>::row.id)->make({state, identity, link, now, 12'345'678, 1'700'000'000'000'000});
        if (!made) return std::nullopt;
        EXPECT_EQ(made->row->id, View<M>::row.id);
        return View<M>{made->payload()};
    }

    VehicleState state;
    VehicleIdentity identity{
        .autopilot = Autopilot::px4,
        .activities = {{{0x10, 0, 1}, Activity::take_off}, {{0x10, 0, 2}, Activity::land}, {{0x10, 0, 12}, Activity::mission}}};
    LinkCounters link;
    TimePoint now{1h};
};

TEST_F(Telemetry, heartbeat_is_uninitialised_until_the_device_reports_its_mode) {
    const auto beat = make<"HEARTBEAT">();
    ASSERT_TRUE(beat);
    EXPECT_EQ(beat->get<"system_status">(), 0);
    EXPECT_EQ(beat->get<"base_mode">(), 0);
    EXPECT_EQ(beat->get<"type">(), 2);
    EXPECT_EQ(beat->get<"autopilot">(), 12);
    EXPECT_EQ(beat->get<"mavlink_version">(), 3);
}

TEST_F(Telemetry, heartbeat_shows_mode_and_arming) {
    mode(2, 0);
    EXPECT_EQ(make<"HEARTBEAT">()->get<"system_status">(), 3);
    EXPECT_EQ(make<"HEARTBEAT">()->get<"base_mode">(), 1 | 16 | 64);
    EXPECT_EQ(make<"HEARTBEAT">()->get<"custom_mode">(), 3u << 16);
    mode(2, 1);
    EXPECT_EQ(make<"HEARTBEAT">()->get<"system_status">(), 4);
    EXPECT_EQ(make<"HEARTBEAT">()->get<"base_mode">(), 1 | 16 | 64 | 128);
    mode(2, 2, {0x10, 0, 1});
    EXPECT_EQ(make<"HEARTBEAT">()->get<"custom_mode">(), 4u << 16 | 2u << 24);
    mode(3, 2, {0x10, 0, 12});
    EXPECT_EQ(make<"HEARTBEAT">()->get<"custom_mode">(), 4u << 16 | 4u << 24);
    identity.autopilot = Autopilot::ardupilot;
    EXPECT_EQ(make<"HEARTBEAT">()->get<"custom_mode">(), 3u);
    EXPECT_EQ(make<"HEARTBEAT">()->get<"autopilot">(), 3);
    now += 3s;
    EXPECT_EQ(make<"HEARTBEAT">()->get<"system_status">(), 0);
}

TEST_F(Telemetry, modes_selected_by_a_station_are_those_shown_to_it) {
    for (const Autopilot autopilot : {Autopilot::generic, Autopilot::px4, Autopilot::ardupilot})
        for (const Activity activity : {Activity::attitude, Activity::height, Activity::position, Activity::land,
                                        Activity::return_home, Activity::mission, Activity::hold})
            EXPECT_EQ(activity_of(autopilot, custom_mode(autopilot, activity)), activity);
    EXPECT_EQ(activity_of(Autopilot::px4, 77), std::nullopt);
}

TEST_F(Telemetry, attitude_is_in_frd_and_ned) {
    // Leans 10° to the right, lowers the nose by 5°, is turned 90° to the left: to the west.
    euler(10, 5, 90);
    ano::Draft<"inertial"> inertial;
    EXPECT_TRUE(inertial.set<"gyr_x">(18.0) && inertial.set<"gyr_y">(36.0) && inertial.set<"gyr_z">(-9.0));
    receive(inertial);
    const auto attitude = make<"ATTITUDE">();
    ASSERT_TRUE(attitude);
    EXPECT_EQ(attitude->get<"time_boot_ms">(), 12'345u);
    EXPECT_NEAR(attitude->get<"roll">(), 10 * degree, 1e-4);
    EXPECT_NEAR(attitude->get<"pitch">(), -5 * degree, 1e-4);
    EXPECT_NEAR(attitude->get<"yaw">(), -90 * degree, 1e-4);
    EXPECT_NEAR(attitude->get<"rollspeed">(), 18 * degree, 1e-3);
    EXPECT_NEAR(attitude->get<"pitchspeed">(), -36 * degree, 1e-3);
    EXPECT_NEAR(attitude->get<"yawspeed">(), 9 * degree, 1e-3);
    const auto q = make<"ATTITUDE_QUATERNION">();
    const ano::Rotation same{q->get<"q1">(), q->get<"q2">(), q->get<"q3">(), q->get<"q4">()};
    EXPECT_NEAR(angles_of(same).yaw, -90 * degree, 1e-4);
    EXPECT_NEAR(angles_of(same).pitch, -5 * degree, 1e-4);
}

TEST_F(Telemetry, a_quaternion_precedes_euler_angles_and_the_key_attitude_is_obeyed) {
    euler(0, 0, 30);
    ano::Draft<"quaternion"> quaternion;
    EXPECT_TRUE(quaternion.set<"v0">(std::cos(30 * degree)) && quaternion.set<"v3">(std::sin(30 * degree)));    // 60° to the left
    receive(quaternion);
    EXPECT_NEAR(make<"ATTITUDE">()->get<"yaw">(), -60 * degree, 1e-3);
    now += 3s;
    state.set_signs(ano::EulerSigns::lx);
    euler(0, 0, 30);    // to the right, by this device
    EXPECT_NEAR(make<"ATTITUDE">()->get<"yaw">(), 30 * degree, 1e-3);
}

TEST_F(Telemetry, positions_and_velocities_are_in_ned) {
    ano::Draft<"velocity"> velocity;
    EXPECT_TRUE(velocity.set<"speed_x">(100) && velocity.set<"speed_y">(200) &&
                velocity.set<"speed_z">(-50));    // north, west, up
    receive(velocity);
    position(1000, 300, 250);
    const auto local = make<"LOCAL_POSITION_NED">();
    ASSERT_TRUE(local);
    EXPECT_FLOAT_EQ(local->get<"x">(), 10);
    EXPECT_FLOAT_EQ(local->get<"y">(), -3);
    EXPECT_FLOAT_EQ(local->get<"z">(), -2.5F);
    EXPECT_FLOAT_EQ(local->get<"vx">(), 1);
    EXPECT_FLOAT_EQ(local->get<"vy">(), -2);
    EXPECT_FLOAT_EQ(local->get<"vz">(), 0.5F);
    EXPECT_FALSE(make<"GLOBAL_POSITION_INT">());
    fix(31.25, 121.5, 5000);
    euler(0, 0, 90);
    const auto global = make<"GLOBAL_POSITION_INT">();
    ASSERT_TRUE(global);
    EXPECT_EQ(global->get<"lat">(), 312'500'000);
    EXPECT_EQ(global->get<"lon">(), 1'215'000'000);
    EXPECT_EQ(global->get<"alt">(), 50'000);
    EXPECT_EQ(global->get<"relative_alt">(), 2500);
    EXPECT_EQ(global->get<"vx">(), 100);
    EXPECT_EQ(global->get<"vy">(), -200);
    EXPECT_EQ(global->get<"vz">(), 50);
    EXPECT_EQ(global->get<"hdg">(), 27'000);
    const auto hud = make<"VFR_HUD">();
    EXPECT_NEAR(hud->get<"groundspeed">(), std::hypot(1, 2), 1e-5);
    EXPECT_EQ(hud->get<"heading">(), 270);
    EXPECT_FLOAT_EQ(hud->get<"climb">(), -0.5F);
    EXPECT_FLOAT_EQ(hud->get<"alt">(), 50);
    EXPECT_TRUE(std::isnan(hud->get<"airspeed">()));
}

TEST_F(Telemetry, gps_raw_int_has_the_values_of_the_receiver) {
    fix(-33.9, -70.1234567, 12'345);
    const auto gps = make<"GPS_RAW_INT">();
    ASSERT_TRUE(gps);
    EXPECT_EQ(gps->get<"fix_type">(), 3);
    EXPECT_EQ(gps->get<"satellites_visible">(), 14);
    EXPECT_EQ(gps->get<"lat">(), -339'000'000);
    EXPECT_EQ(gps->get<"lon">(), -701'234'567);
    EXPECT_EQ(gps->get<"alt">(), 123'450);
    EXPECT_EQ(gps->get<"vel">(), 50);
    EXPECT_EQ(gps->get<"cog">(), 30'687);    // atan2(-40, 30)
    EXPECT_EQ(gps->get<"eph">(), 200);
    EXPECT_EQ(gps->get<"vel_acc">(), 200u);
    EXPECT_EQ(gps->get<"v_acc">(), 1500u);
    fix(0, 0, 0, 0);
    EXPECT_EQ(make<"GPS_RAW_INT">()->get<"fix_type">(), 1);
    EXPECT_FALSE(make<"GLOBAL_POSITION_INT">());
}

TEST_F(Telemetry, home_is_where_the_vehicle_was_unlocked_until_it_is_unlocked_again) {
    EXPECT_FALSE(make<"HOME_POSITION">());
    mode(2, 0);
    fix(31, 121, 4000);
    position(500, 500, 0);    // from the take-off point of the flight before
    fix(31.0001, 121, 4000);
    EXPECT_EQ(make<"HOME_POSITION">()->get<"latitude">(), 310'001'000);
    mode(2, 1);
    fix(31.5, 121, 9000);
    EXPECT_EQ(make<"HOME_POSITION">()->get<"latitude">(), 310'001'000);
    EXPECT_EQ(make<"HOME_POSITION">()->get<"altitude">(), 40'000);
    mode(2, 0);
    fix(31.5, 121, 9000);
    EXPECT_EQ(make<"HOME_POSITION">()->get<"latitude">(), 315'000'000);
}

TEST_F(Telemetry, home_of_a_vehicle_in_the_air_is_found_by_its_way) {
    mode(2, 2);
    position(11'119, -11'119 / 2, 300);    // 111.19 m north, half of it east
    fix(60, 10, 5000);
    const auto home = make<"HOME_POSITION">();
    ASSERT_TRUE(home);
    EXPECT_NEAR(home->get<"latitude">(), 599'990'000, 10);
    EXPECT_NEAR(home->get<"longitude">(), 99'990'000, 30);    // at 60° a degree is half as long
    EXPECT_EQ(home->get<"altitude">(), 47'000);
}

TEST_F(Telemetry, inertial_values_are_in_milli_units_and_frd) {
    ano::Draft<"inertial"> inertial;
    EXPECT_TRUE(inertial.set<"acc_x">(98) && inertial.set<"acc_y">(196) && inertial.set<"acc_z">(981) &&
                inertial.set<"gyr_z">(18.0));
    receive(inertial);
    ano::Draft<"compass"> compass;
    EXPECT_TRUE(compass.set<"mag_x">(300) && compass.set<"mag_y">(-100) && compass.set<"mag_z">(-400) &&
                compass.set<"tmp">(25.5));
    receive(compass);
    const auto imu = make<"SCALED_IMU">();
    ASSERT_TRUE(imu);
    EXPECT_EQ(imu->get<"xacc">(), 100);
    EXPECT_EQ(imu->get<"yacc">(), -200);
    EXPECT_EQ(imu->get<"zacc">(), -1000);
    EXPECT_EQ(imu->get<"zgyro">(), -314);
    EXPECT_EQ(imu->get<"xmag">(), 300);
    EXPECT_EQ(imu->get<"ymag">(), 100);
    EXPECT_EQ(imu->get<"zmag">(), 400);
    EXPECT_EQ(imu->get<"temperature">(), 2550);
    EXPECT_EQ(make<"RAW_IMU">()->get<"zacc">(), -1000);
}

TEST_F(Telemetry, battery_is_divided_among_its_cells) {
    ano::Draft<"power"> power;
    EXPECT_TRUE(power.set<"voltage">(16.2) && power.set<"current">(12.34));
    receive(power);
    EXPECT_EQ(make<"SYS_STATUS">()->get<"voltage_battery">(), 16'200);
    EXPECT_EQ(make<"SYS_STATUS">()->get<"current_battery">(), 1234);
    EXPECT_EQ(make<"SYS_STATUS">()->get<"battery_remaining">(), -1);
    EXPECT_EQ(make<"BATTERY_STATUS">()->get<"voltages">(0), 16'200);
    EXPECT_EQ(make<"BATTERY_STATUS">()->get<"voltages">(1), 0xFFFF);
    identity.cells = 4;
    EXPECT_EQ(make<"BATTERY_STATUS">()->get<"voltages">(3), 4050);
    EXPECT_EQ(make<"BATTERY_STATUS">()->get<"voltages">(4), 0xFFFF);
    EXPECT_EQ(make<"BATTERY_STATUS">()->get<"current_battery">(), 1234);
    EXPECT_EQ(make<"BATTERY_STATUS">()->get<"battery_remaining">(), -1);
}

TEST_F(Telemetry, landed_state_follows_safety_and_command) {
    mode(2, 0);
    EXPECT_EQ(make<"EXTENDED_SYS_STATE">()->get<"landed_state">(), 1);
    mode(2, 1, {0x10, 0, 1});
    EXPECT_EQ(make<"EXTENDED_SYS_STATE">()->get<"landed_state">(), 3);
    mode(2, 2);
    EXPECT_EQ(make<"EXTENDED_SYS_STATE">()->get<"landed_state">(), 2);
    mode(2, 2, {0x10, 0, 2});
    EXPECT_EQ(make<"EXTENDED_SYS_STATE">()->get<"landed_state">(), 4);
}

TEST_F(Telemetry, channels_and_outputs) {
    ano::Draft<"remote_control"> sticks;
    EXPECT_TRUE(sticks.set<"rol">(1500) && sticks.set<"pit">(1501) && sticks.set<"thr">(1100) && sticks.set<"yaw">(1503) &&
                sticks.set<"aux6">(2000));
    receive(sticks);
    const auto channels = make<"RC_CHANNELS">();
    ASSERT_TRUE(channels);
    EXPECT_EQ(channels->get<"chan3_raw">(), 1100);
    EXPECT_EQ(channels->get<"chan10_raw">(), 2000);
    EXPECT_EQ(channels->get<"chan5_raw">(), 0xFFFF);
    EXPECT_EQ(channels->get<"chan11_raw">(), 0xFFFF);
    EXPECT_EQ(channels->get<"chancount">(), 10);
    ano::Draft<"pwm"> pwm;
    EXPECT_TRUE(pwm.set<"pwm1">(0) && pwm.set<"pwm2">(50) && pwm.set<"pwm3">(100) && pwm.set<"pwm4">(12.34));
    receive(pwm);
    const auto servos = make<"SERVO_OUTPUT_RAW">();
    EXPECT_EQ(servos->get<"servo1_raw">(), 1000);
    EXPECT_EQ(servos->get<"servo2_raw">(), 1500);
    EXPECT_EQ(servos->get<"servo3_raw">(), 2000);
    EXPECT_EQ(servos->get<"servo4_raw">(), 1123);
    EXPECT_EQ(servos->get<"servo5_raw">(), 0);
}

TEST_F(Telemetry, distances_are_shown_by_side_and_all_round) {
    ano::Draft<"ranging"> down;
    EXPECT_TRUE(down.set<"type">(6) && down.set<"dist">(2345));
    receive(down);
    const auto sensor = make<"DISTANCE_SENSOR">();
    ASSERT_TRUE(sensor);
    EXPECT_EQ(sensor->get<"current_distance">(), 235);
    EXPECT_EQ(sensor->get<"orientation">(), 25);
    EXPECT_NEAR(make<"OPTICAL_FLOW">() ? 0 : 1, 1, 0);
    const support::Bytes points = support::hex(
        "64 28 23 96 00 9C 8C 0A 00 00 00 00 00");    // 90° 150 cm, 359.96° 10 cm, 0° nothing
    const support::Bytes bytes = support::frame(fc, 0xFF, 0x34, points);
    state.receive(ano::read(*ano::frame_at(bytes)), now);
    const auto obstacles = make<"OBSTACLE_DISTANCE">();
    ASSERT_TRUE(obstacles);
    EXPECT_EQ(obstacles->get<"distances">(0), 10);
    EXPECT_EQ(obstacles->get<"distances">(18), 150);
    EXPECT_EQ(obstacles->get<"distances">(19), 0xFFFF);
    EXPECT_EQ(obstacles->get<"increment">(), 5);
    EXPECT_EQ(obstacles->get<"frame">(), 12);
}

TEST_F(Telemetry, wind_flow_targets_and_the_way_home) {
    ano::Draft<"wind"> wind;
    EXPECT_TRUE(wind.set<"wind_x">(100) && wind.set<"wind_y">(-250));
    receive(wind);
    EXPECT_FLOAT_EQ(make<"WIND_COV">()->get<"wind_x">(), 1);
    EXPECT_FLOAT_EQ(make<"WIND_COV">()->get<"wind_y">(), 2.5F);
    ano::Draft<"target_attitude"> target;
    EXPECT_TRUE(target.set<"tar_rol">(3) && target.set<"tar_pit">(4) && target.set<"tar_yaw">(-20));
    receive(target);
    ano::Draft<"return_home"> home;
    EXPECT_TRUE(home.set<"r_a">(90.0) && home.set<"r_d">(123));
    receive(home);
    const auto nav = make<"NAV_CONTROLLER_OUTPUT">();
    ASSERT_TRUE(nav);
    EXPECT_NEAR(nav->get<"nav_roll">(), 3, 1e-4);
    EXPECT_NEAR(nav->get<"nav_pitch">(), -4, 1e-4);
    EXPECT_EQ(nav->get<"nav_bearing">(), 20);
    EXPECT_EQ(nav->get<"target_bearing">(), 270);
    EXPECT_EQ(nav->get<"wp_dist">(), 123);
    ano::Draft<"optical_flow", "mode1"> flow;
    EXPECT_TRUE(flow.set<"mode">(1) && flow.set<"state">(1) && flow.set<"dx_1">(25) && flow.set<"dy_1">(50) &&
                flow.set<"quality">(200));
    receive(flow);
    EXPECT_FLOAT_EQ(make<"OPTICAL_FLOW">()->get<"flow_comp_m_x">(), 0.25F);
    EXPECT_FLOAT_EQ(make<"OPTICAL_FLOW">()->get<"flow_comp_m_y">(), -0.5F);
    EXPECT_EQ(make<"OPTICAL_FLOW">()->get<"quality">(), 200);
    EXPECT_FLOAT_EQ(make<"OPTICAL_FLOW">()->get<"ground_distance">(), -1);
}

TEST_F(Telemetry, altitudes) {
    ano::Draft<"altitude"> altitude;
    EXPECT_TRUE(altitude.set<"alt_bar">(12'300) && altitude.set<"alt_add">(150) && altitude.set<"alt_fu">(160));
    receive(altitude);
    const auto shown = make<"ALTITUDE">();
    ASSERT_TRUE(shown);
    EXPECT_FLOAT_EQ(shown->get<"altitude_monotonic">(), 123);
    EXPECT_FLOAT_EQ(shown->get<"altitude_local">(), 1.6F);
    EXPECT_FLOAT_EQ(shown->get<"altitude_relative">(), 1.6F);
    EXPECT_TRUE(std::isnan(shown->get<"altitude_amsl">()));
    EXPECT_FLOAT_EQ(shown->get<"altitude_terrain">(), -1000);
    EXPECT_FLOAT_EQ(shown->get<"bottom_clearance">(), -1);
}

TEST_F(Telemetry, autopilot_version_states_what_is_configured) {
    identity.software = 123;
    EXPECT_EQ(make<"AUTOPILOT_VERSION">()->get<"capabilities">(), 16u | 8u | 8192u);
    identity.has_missions = true;
    EXPECT_EQ(make<"AUTOPILOT_VERSION">()->get<"capabilities">(), 16u | 8u | 4u | 8192u);
    EXPECT_EQ(make<"AUTOPILOT_VERSION">()->get<"flight_sw_version">() >> 24, 1u);
    EXPECT_EQ(make<"AUTOPILOT_VERSION">()->get<"flight_custom_version">(0), 123);
    identity.autopilot = Autopilot::generic;
    EXPECT_EQ(make<"AUTOPILOT_VERSION">()->get<"flight_sw_version">(), 1u << 24 | 23u << 16);
}

TEST_F(Telemetry, link_status_and_losses) {
    link = {.sent = 10, .received = 90, .lost = 10, .bad = 3};
    EXPECT_EQ(make<"SYS_STATUS">()->get<"drop_rate_comm">(), 1000);
    EXPECT_EQ(make<"SYS_STATUS">()->get<"errors_comm">(), 3);
    EXPECT_EQ(make<"LINK_NODE_STATUS">()->get<"messages_lost">(), 10u);
    EXPECT_EQ(make<"LINK_NODE_STATUS">()->get<"messages_sent">(), 10u);
}

TEST_F(Telemetry, old_values_are_not_sent) {
    euler(0, 0, 0);
    position(0, 0, 0);
    now += 2001ms;
    EXPECT_FALSE(make<"ATTITUDE">());
    EXPECT_FALSE(make<"LOCAL_POSITION_NED">());
}

TEST(StatusTexts, are_cut_between_characters) {
    const auto one = status_texts(Severity::warning, "battery low", 7);
    ASSERT_EQ(one.size(), 1u);
    EXPECT_EQ(View<"STATUSTEXT">{one[0].payload()}.get<"id">(), 0);
    std::string text;
    for (int i = 0; i < 20; ++i) text += "电";
    const auto parts = status_texts(Severity::info, text, 7);
    ASSERT_EQ(parts.size(), 2u);
    std::string whole;
    for (const Payload& part : parts) whole += View<"STATUSTEXT">{part.payload()}.get<"text">();
    EXPECT_EQ(whole, text);
    EXPECT_EQ(View<"STATUSTEXT">{parts[0].payload()}.get<"text">().size(), 48u);
    EXPECT_EQ(View<"STATUSTEXT">{parts[1].payload()}.get<"chunk_seq">(), 1);
    EXPECT_EQ(View<"STATUSTEXT">{parts[1].payload()}.get<"id">(), 7);
    EXPECT_EQ(status_texts(Severity::info, std::string(100, 'a'), 7).size(), 3u);
    EXPECT_EQ(status_texts(Severity::info, "", 7).size(), 1u);
}

TEST(NamedValues, have_the_names_and_values_of_a_flexible_message) {
    const ano::FlexibleSpec spec{
        .id = 0xF1,
        .fields = {{.name = "rpm", .type = ano::Type::u16, .scale = 2, .unit = "", .count = 1},
                   {.name = "cell_voltages", .type = ano::Type::u8, .scale = 0.5, .unit = "", .count = 3}}};
    const ano::FlexibleLayouts layouts{std::span{&spec, 1}};
    const support::Bytes bytes = support::frame(fc, 0xFF, 0xF1, support::hex("0A 00 01 02 03"));
    const auto values = named_values(ano::read(*ano::frame_at(bytes), &layouts), 5'000'000);
    ASSERT_EQ(values.size(), 2u);
    const View<"NAMED_VALUE_FLOAT"> rpm{values[0].payload()};
    EXPECT_EQ(rpm.get<"name">(), "rpm");
    EXPECT_FLOAT_EQ(rpm.get<"value">(), 20);
    EXPECT_EQ(rpm.get<"time_boot_ms">(), 5000u);
    const View<"DEBUG_FLOAT_ARRAY"> cells{values[1].payload()};
    EXPECT_EQ(cells.get<"name">(), "cell_volta");
    EXPECT_FLOAT_EQ(cells.get<"data">(2), 1.5F);
}

class Schedule : public testing::Test {
protected:
    // How often each message is sent within `time`, by a link that accepts a packet every `step`.
    std::map<std::uint32_t, int> sent(ano::Duration time, ano::Duration step) {
        std::map<std::uint32_t, int> counts;
        for (const TimePoint end = now + time; now < end; now += step)
            if (const auto row = schedule.next(now)) {
                schedule.on_sent(*row, now);
                ++counts[telemetry_rows()[*row].id];
            }
        return counts;
    }
    TimePoint now{1h};
    TelemetrySchedule schedule{now};
};

TEST_F(Schedule, sends_at_the_usual_rates) {
    const auto counts = sent(10s, 1ms);
    EXPECT_NEAR(counts.at(id_of<"ATTITUDE">), 500, 2);
    EXPECT_NEAR(counts.at(id_of<"GLOBAL_POSITION_INT">), 100, 2);
    EXPECT_NEAR(counts.at(id_of<"HEARTBEAT">), 10, 1);
    EXPECT_FALSE(counts.contains(id_of<"AUTOPILOT_VERSION">));
}

TEST_F(Schedule, obeys_intervals) {
    EXPECT_TRUE(schedule.set_interval(id_of<"ATTITUDE">, 500'000, now));
    EXPECT_TRUE(schedule.set_interval(id_of<"VFR_HUD">, -1, now));
    EXPECT_FALSE(schedule.set_interval(id_of<"COMMAND_LONG">, 100'000, now));
    EXPECT_FALSE(schedule.set_interval(id_of<"ATTITUDE">, std::nan(""), now));
    EXPECT_EQ(schedule.interval_us(id_of<"ATTITUDE">), 500'000);
    EXPECT_EQ(schedule.interval_us(id_of<"VFR_HUD">), -1);
    EXPECT_EQ(schedule.interval_us(id_of<"COMMAND_LONG">), 0);
    auto counts = sent(10s, 1ms);
    EXPECT_NEAR(counts[id_of<"ATTITUDE">], 20, 1);
    EXPECT_EQ(counts[id_of<"VFR_HUD">], 0);
    EXPECT_TRUE(schedule.set_interval(id_of<"VFR_HUD">, 0, now));
    EXPECT_EQ(schedule.interval_us(id_of<"VFR_HUD">), 100'000);
}

TEST_F(Schedule, obeys_requests_of_streams) {
    EXPECT_TRUE(schedule.set_stream(0, 0, false, now));
    auto counts = sent(2s, 1ms);
    EXPECT_EQ(counts.size(), 1u);    // the heartbeat stays
    EXPECT_TRUE(schedule.set_stream(10, 4, true, now));
    EXPECT_FALSE(schedule.set_stream(77, 4, true, now));
    counts = sent(10s, 1ms);
    EXPECT_NEAR(counts[id_of<"ATTITUDE">], 40, 1);
    EXPECT_FALSE(counts.contains(id_of<"VFR_HUD">));
}

TEST_F(Schedule, shares_a_slow_link_by_rates_and_makes_up_for_nothing) {
    auto counts = sent(20s, 50ms);    // 20 packets/s
    EXPECT_GT(counts[id_of<"HEARTBEAT">], 0);
    EXPECT_GT(counts[id_of<"ATTITUDE">], counts[id_of<"VFR_HUD">]);
    now += 10s;
    EXPECT_LE(sent(1s, 1ms).at(id_of<"ATTITUDE">), 52);
}

}    // namespace
}    // namespace mavlink_telemetry_tests
