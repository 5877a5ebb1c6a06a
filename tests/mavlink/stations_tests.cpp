// anogate-mavlink as a process, with ground stations that the test plays.
#include "station.hpp"

#include <cmath>
#include <set>

namespace stations_tests {
namespace {

using namespace mavlink_tests;

constexpr float none = std::numeric_limits<float>::quiet_NaN();

Draft<"MISSION_ITEM_INT"> item(std::uint16_t number, std::int32_t lat, std::int32_t lng, float altitude,
                               std::uint16_t command = 16) {
    Draft<"MISSION_ITEM_INT"> draft;
    draft.set<"target_system">(1)
        .set<"target_component">(1)
        .set<"seq">(number)
        .set<"frame">(6)
        .set<"command">(command)
        .set<"autocontinue">(1);
    return draft.set<"param4">(none).set<"x">(lat).set<"y">(lng).set<"z">(altitude);
}

// What QGroundControl does when it connects: it asks for the version, all parameters and the mission. Then it flies, and is lost.
TEST_F(Stations, a_session_from_the_first_heartbeat_to_a_lost_link) {
    start();
    const auto beat = station.until<"HEARTBEAT">([](const auto& one) { return one.template get<"system_status">() == 3; });
    ASSERT_TRUE(beat) << program->output();
    EXPECT_EQ(beat->get<"type">(), 2);
    EXPECT_EQ(beat->get<"autopilot">(), 12);

    EXPECT_EQ(station.command(Command::request_message, {148}), 0);
    const auto version = station.until<"AUTOPILOT_VERSION">();
    ASSERT_TRUE(version);
    EXPECT_EQ(version->get<"capabilities">() & (4u | 8u | 16u), 4u | 8u | 16u);

    station.send(Draft<"PARAM_REQUEST_LIST">{}.set<"target_system">(1).set<"target_component">(1));
    std::set<int> indices;
    int count = 0;
    while (count == 0 || static_cast<int>(indices.size()) < count) {
        const auto value = station.until<"PARAM_VALUE">();
        ASSERT_TRUE(value) << program->output();
        count = value->get<"param_count">();
        indices.insert(value->get<"param_index">());
        EXPECT_LE(value->get<"param_id">().size(), 16u);
    }
    EXPECT_GT(count, 90);
    station.send(Draft<"PARAM_SET">{}
                     .set<"target_system">(1)
                     .set_text<"param_id">("SIM_WIND")
                     .set<"param_type">(9)
                     .set<"param_value">(2.5F));
    const auto stored = station.until<"PARAM_VALUE">([](const auto& one) {
        return one.template get<"param_id">() == "SIM_WIND" && one.template get<"param_value">() == 2.5F;
    });
    EXPECT_TRUE(stored);

    const auto home = station.until<"HOME_POSITION">();
    ASSERT_TRUE(home);
    const std::int32_t lat = home->get<"latitude">(), lng = home->get<"longitude">();
    const auto request_mission = [this] {
        station.send(Draft<"MISSION_REQUEST_LIST">{}.set<"target_system">(1).set<"target_component">(1));
    };
    request_mission();
    EXPECT_EQ(station.until<"MISSION_COUNT">([](const auto&) { return true; }, request_mission)->get<"count">(), 0);

    // What can't be expressed is refused, with its number.
    station.send(Draft<"MISSION_COUNT">{}.set<"target_system">(1).set<"target_component">(1).set<"count">(1));
    ASSERT_TRUE(station.until<"MISSION_REQUEST_INT">());
    station.send(item(0, lat, lng, 3, 22));
    EXPECT_EQ(station.until<"MISSION_ACK">()->get<"type">(), 3);
    EXPECT_TRUE(
        station.until<"STATUSTEXT">([](const auto& one) { return one.template get<"text">().starts_with("mission item 0: "); }));

    station.send(Draft<"MISSION_COUNT">{}.set<"target_system">(1).set<"target_component">(1).set<"count">(2));
    for (std::uint16_t i = 0; i < 2; ++i) {
        const auto asked = station.until<"MISSION_REQUEST_INT">([i](const auto& one) { return one.template get<"seq">() == i; });
        ASSERT_TRUE(asked) << program->output();
        station.send(item(i, lat + 100 * i, lng, 3));
    }
    EXPECT_EQ(station.until<"MISSION_ACK">()->get<"type">(), 0) << program->output();
    request_mission();
    EXPECT_EQ(station.until<"MISSION_COUNT">()->get<"count">(), 2);
    station.send(Draft<"MISSION_REQUEST_INT">{}.set<"target_system">(1).set<"target_component">(1).set<"seq">(1));
    const auto back = station.until<"MISSION_ITEM_INT">();
    ASSERT_TRUE(back);
    EXPECT_EQ(back->get<"x">(), lat + 100);
    EXPECT_FLOAT_EQ(back->get<"z">(), 3);
    EXPECT_TRUE(std::isnan(back->get<"param4">()));

    EXPECT_EQ(station.command(Command::arm_disarm, {1}), 0);
    EXPECT_TRUE(station.until<"HEARTBEAT">([](const auto& one) { return (one.template get<"base_mode">() & 128u) != 0; }));
    const float above_sea = static_cast<float>(home->get<"altitude">()) / 1000 + 2;
    EXPECT_EQ(station.command(Command::nav_takeoff, {-1, 0, 0, none, none, none, above_sea}), 0);
    EXPECT_TRUE(station.until<"EXTENDED_SYS_STATE">([](const auto& one) { return one.template get<"landed_state">() == 3; }));
    EXPECT_TRUE(station.until<"GLOBAL_POSITION_INT">([](const auto& one) { return one.template get<"relative_alt">() > 700; }));
    EXPECT_TRUE(station.until<"EXTENDED_SYS_STATE">([](const auto& one) { return one.template get<"landed_state">() == 2; }));
    EXPECT_EQ(station.command(Command::do_set_mode, {1, 4, 4}), 0);    // PX4's Mission
    EXPECT_TRUE(
        station.until<"HEARTBEAT">([](const auto& one) { return one.template get<"custom_mode">() == (4u << 16 | 4u << 24); }));
    EXPECT_TRUE(station.until<"MISSION_ITEM_REACHED">());
    EXPECT_EQ(station.command(Command::do_reposition, {-1, 1, 0, none, none, none, none}), 0);
    EXPECT_EQ(station.command(Command::nav_land), 0);
    EXPECT_EQ(station.command(Command::preflight_reboot, {1}), 3);    // the device has no such command
    // The station is lost: the program goes on.
    station.is_silent = true;
    EXPECT_TRUE(station.until<"EXTENDED_SYS_STATE">([](const auto& one) { return one.template get<"landed_state">() == 1; }));
    EXPECT_TRUE(program->is_running());
    program->signal(SIGTERM);
    EXPECT_EQ(program->wait(), 0) << program->output();
}

TEST_F(Stations, nothing_is_sent_before_the_heartbeat_of_a_station_and_our_own_ids_are_refused) {
    const std::uint16_t port = support::UdpPeer{}.port();    // free again
    start("{}", {"--udp-listen", "127.0.0.1:" + std::to_string(port)});
    station.set_program(port);
    station.is_silent = true;
    Station other;
    other.set_program(port);
    // The program is there when it answers another station.
    ASSERT_TRUE(other.until<"HEARTBEAT">()) << program->output();
    for (int i = 0; i < 50; ++i) station.send(Draft<"PARAM_REQUEST_LIST">{}.set<"target_system">(1));
    Station forger{1};
    forger.set_program(port);
    forger.is_silent = true;
    for (int i = 0; i < 50; ++i) forger.heartbeat();
    ASSERT_TRUE(other.until<"ATTITUDE">());
    station.turn();
    forger.turn();
    EXPECT_EQ(station.datagrams(), 0u);
    EXPECT_EQ(forger.datagrams(), 0u);
    station.is_silent = false;
    EXPECT_TRUE(station.until<"ATTITUDE">());
}

TEST_F(Stations, sticks_are_refused_unless_configured_and_an_invalid_configuration_is_refused) {
    const auto check = [this](const std::string& config) {
        const std::string file = dir.write("checked.json", config);
        support::Process checked{ANOGATE_MAVLINK, {"--check", "--udp", "127.0.0.1:14550", "--config", file}};
        const int status = checked.wait();
        return std::pair{status, checked.output()};
    };
    EXPECT_EQ(check("{}").first, 0);
    EXPECT_EQ(
        check(
            R"({"autopilot": "ardupilot", "devices": [{"address": 220, "system": 3, "funs": [{"kind": "hold", "fun": 1, "cmd": ["hold_s"]}]}]})")
            .first,
        0);
    EXPECT_EQ(check(R"({"udpp": 1})").first, 78);
    EXPECT_EQ(check(R"({"devices": [{"address": 220, "system": 3, "accept": ["velocity"]}]})").first, 78);
    EXPECT_EQ(check(R"({"devices": [{"address": 220, "system": 3, "accept": ["manual_control"]}]})").first, 78);
    EXPECT_EQ(check(R"({"devices": [{"address": 220, "system": 3}, {"address": 221, "system": 3}]})").first, 78);
    EXPECT_NE(check(R"({"devices": [{"address": 220, "system": 3, "funs": [{"kind": "x", "fun": 1}]}]})")
                  .second.find("/devices/0/funs/0"),
              std::string::npos);
}

}    // namespace
}    // namespace stations_tests
