// The mission protocol with a station that the test plays, and a device that answers at once.
#include <mavlink/mission_server.hpp>

#include <gtest/gtest.h>
#include <support/bytes.hpp>

#include <cmath>

namespace mavlink_missions_tests {
namespace {

using namespace anogate::mavlink;
using namespace std::chrono_literals;
using support::Bytes;

constexpr Origin station{255, 190};
constexpr std::uint16_t waypoint = 16, speed_change = 178, take_off = 22;

MissionItem item(double lat, double lng, float altitude, std::uint16_t command = waypoint) {
    return {3,
            command,
            {0, 0, 0, std::nanf("")},
            static_cast<std::int32_t>(std::lround(lat * 1e7)),
            static_cast<std::int32_t>(std::lround(lng * 1e7)),
            altitude};
}
MissionItem speed(float metres) { return {2, speed_change, {1, metres, -1, 0}, 0, 0, 0}; }

MissionContext context(const std::vector<FunRow>& funs) {
    MissionContext result{funs, {}, 40.0};
    result.home.lat = 31;
    result.home.lng = 121;
    return result;
}
std::vector<Waypoint> translated(const std::vector<MissionItem>& items, const std::vector<FunRow>& funs = usual_funs()) {
    const auto result = waypoints_of(items, context(funs));
    EXPECT_TRUE(std::holds_alternative<std::vector<Waypoint>>(result));
    return std::holds_alternative<std::vector<Waypoint>>(result) ? std::get<std::vector<Waypoint>>(result)
                                                                 : std::vector<Waypoint>{};
}
MissionRefusal refused(const std::vector<MissionItem>& items, const std::vector<FunRow>& funs = usual_funs()) {
    const auto result = waypoints_of(items, context(funs));
    EXPECT_TRUE(std::holds_alternative<MissionRefusal>(result));
    return std::holds_alternative<MissionRefusal>(result) ? std::get<MissionRefusal>(result) : MissionRefusal{};
}

TEST(WaypointsOf, have_place_height_yaw_speed_and_time) {
    auto there = item(31.1, 121.2, 12.5);
    there.parameters = {7, 0, 0, -90};
    const auto all = translated({item(31, 121, 5), speed(3.5), there});
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].num, 1);
    EXPECT_EQ(all[0].alt, 500);
    EXPECT_EQ(all[0].spd, 0);
    EXPECT_EQ(all[0].yaw, 400);
    EXPECT_EQ(all[0].fun, 0);
    EXPECT_DOUBLE_EQ(all[1].lat, 31.1);
    EXPECT_DOUBLE_EQ(all[1].lng, 121.2);
    EXPECT_EQ(all[1].alt, 1250);
    EXPECT_EQ(all[1].spd, 350);
    EXPECT_EQ(all[1].yaw, 270);
    EXPECT_EQ(all[1].fun, 1);
    EXPECT_EQ(all[1].cmd[0], 7);
}

TEST(WaypointsOf, altitudes_above_sea_level_are_converted) {
    auto high = item(31, 121, 50);
    high.frame = 0;
    EXPECT_EQ(translated({high})[0].alt, 1000);
    high.frame = 10;
    EXPECT_EQ(refused({high}).result, MissionResult::unsupported_frame);
}

TEST(WaypointsOf, items_are_refused_with_their_number_and_reason) {
    const auto refusal_of = [](const MissionItem& bad) { return refused({item(31, 121, 5), item(31, 121, 5), bad}); };
    EXPECT_EQ(refusal_of(item(31, 121, 5, take_off)).result, MissionResult::unsupported);
    EXPECT_EQ(refusal_of(item(31, 121, 5, take_off)).item, 2u);
    EXPECT_EQ(refusal_of(item(95, 121, 5)).result, MissionResult::invalid_latitude);
    EXPECT_EQ(refusal_of(item(31, 185, 5)).result, MissionResult::invalid_longitude);
    EXPECT_EQ(refusal_of(item(31, 121, std::nanf(""))).result, MissionResult::invalid_altitude);
    auto bad = item(31, 121, 5);
    bad.parameters[0] = 2.5;
    EXPECT_EQ(refusal_of(bad).result, MissionResult::invalid_parameter_1);
    bad.parameters = {0, 3, 0, 0};
    EXPECT_EQ(refusal_of(bad).result, MissionResult::invalid_parameter_2);
    bad.parameters = {0, 0, -3, 0};
    EXPECT_EQ(refusal_of(bad).result, MissionResult::invalid_parameter_3);
    EXPECT_EQ(refusal_of(speed(0)).result, MissionResult::invalid_parameter_2);
    EXPECT_EQ(refusal_of(speed(3)).result, MissionResult::unsupported);    // for no waypoint
    EXPECT_EQ(refused(std::vector<MissionItem>(255, item(31, 121, 5))).result, MissionResult::no_space);
}

TEST(WaypointsOf, kinds_of_items_are_those_of_the_table) {
    const std::vector<FunRow> funs{
        {ItemKind::take_off, 10, {ItemByte{false, 3}}}, {ItemKind::return_home, 12, {}}, {ItemKind::waypoint, 5, {}}};
    const auto all = translated({item(0, 0, 5, take_off), item(31.5, 121, 6), item(0, 0, 0, 20)}, funs);
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0].fun, 10);
    EXPECT_EQ(all[0].cmd[0], 3);
    EXPECT_DOUBLE_EQ(all[0].lat, 31);    // at home
    EXPECT_EQ(all[1].fun, 5);
    EXPECT_EQ(all[2].fun, 12);
}

TEST(ItemsOf, are_those_that_were_uploaded) {
    auto stays = item(31.1, 121.2, 12.5);
    stays.parameters = {7, 0, 0, 90};
    const std::vector<MissionItem> items{item(31, 121, 5), speed(3.5), stays, item(31.2, 121, 8), speed(2), item(31.3, 121, 8)};
    const auto back = items_of(translated(items), usual_funs());
    ASSERT_EQ(back.size(), items.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
        EXPECT_EQ(back[i].command, items[i].command);
        EXPECT_EQ(back[i].lat, items[i].lat);
        EXPECT_FLOAT_EQ(back[i].altitude, items[i].altitude);
        EXPECT_EQ(back[i].parameters[0], items[i].parameters[0]);
        EXPECT_EQ(std::isnan(back[i].parameters[3]), std::isnan(items[i].parameters[3]));
    }
    EXPECT_EQ(waypoint_of_item(items, 0), 1);
    EXPECT_EQ(waypoint_of_item(items, 2), 2);
    EXPECT_EQ(waypoint_of_item(items, 5), 4);
}

class Missions : public testing::Test {
protected:
    struct Sent {
        Origin to;
        Payload payload;
    };
    template <class D>
    void receive(const D& draft, Origin from = station, Version version = Version::v2) {
        Bytes bytes(max_packet);
        bytes.resize(encode(bytes, version, from, 0, draft.row, draft.payload()));
        server.receive(PacketView{bytes}, now);
    }
    void count(int items, Origin from = station) { receive(Draft<"MISSION_COUNT">{}.set<"count">(items), from); }
    void send(int number, const MissionItem& what, Origin from = station) {
        Draft<"MISSION_ITEM_INT"> draft;
        draft.set<"seq">(number).set<"frame">(what.frame).set<"command">(what.command).set<"x">(what.lat).set<"y">(what.lng);
        draft.set<"param1">(what.parameters[0]).set<"param2">(what.parameters[1]).set<"param3">(what.parameters[2]);
        receive(draft.set<"param4">(what.parameters[3]).set<"z">(what.altitude), from);
    }
    template <ano::Name M>
    View<M> last() {
        EXPECT_FALSE(sent.empty());
        if (sent.empty()) return View<M>{{}};
        EXPECT_EQ(sent.back().payload.row->name, M.view());
        return View<M>{sent.back().payload.payload()};
    }
    int requested() { return last<"MISSION_REQUEST_INT">().template get<"seq">(); }
    MissionResult ended() { return static_cast<MissionResult>(last<"MISSION_ACK">().template get<"type">()); }

    std::vector<Waypoint> device{Waypoint{}};
    std::vector<Sent> sent;
    std::vector<Payload> sent_to_all;
    std::vector<std::string> reports;
    std::vector<std::uint8_t> flown_from;
    int writes = 0;
    std::string error;
    MissionServer server{usual_funs(),
                         {.read = [this](const auto& done) { done(device, error); },
                          .write =
                              [this](const std::vector<Waypoint>& waypoints, const auto& done) {
                                  ++writes;
                                  device.resize(1);
                                  device.insert(device.end(), waypoints.begin(), waypoints.end());
                                  done("");
                              },
                          .clear = {},
                          .fly_from = [this](std::uint8_t first) { flown_from.push_back(first); },
                          .send =
                              [this](Origin to, const Payload& payload) {
                                  sent.push_back({to, payload});
                              },
                          .send_to_all = [this](const Payload& payload) { sent_to_all.push_back(payload); },
                          .report = [this](Severity, const std::string& text) { reports.push_back(text); }}};
    ano::TimePoint now{1h};
};

TEST_F(Missions, are_uploaded_item_by_item_and_written_at_the_end) {
    count(2);
    EXPECT_EQ(requested(), 0);
    send(0, item(31, 121, 5));
    send(0, item(31, 121, 5));    // repeated on the way
    EXPECT_EQ(requested(), 1);
    EXPECT_EQ(writes, 0);
    send(1, item(31.001, 121, 6));
    EXPECT_EQ(ended(), MissionResult::accepted);
    EXPECT_EQ(writes, 1);
    ASSERT_EQ(device.size(), 3u);
    EXPECT_EQ(device[2].alt, 600);
}

TEST_F(Missions, items_that_are_lost_are_requested_again_until_the_station_is_gone) {
    count(1);
    for (int i = 1; i < MissionServer::max_requests; ++i) {
        now += 1s;
        server.on_time(now);
        EXPECT_EQ(requested(), 0);
    }
    now += 1s;
    server.on_time(now);
    EXPECT_EQ(ended(), MissionResult::cancelled);
    EXPECT_EQ(writes, 0);
}

TEST_F(Missions, that_can_not_be_expressed_are_refused_before_anything_is_written) {
    count(2);
    send(0, item(31, 121, 5));
    send(1, item(31, 121, 5, take_off));
    EXPECT_EQ(ended(), MissionResult::unsupported);
    EXPECT_EQ(writes, 0);
    EXPECT_EQ(reports.at(0), "mission item 1: the device has no waypoint for command 22");
}

TEST_F(Missions, shorter_than_that_of_the_device_need_a_command_that_removes_waypoints) {
    device.resize(4);
    for (std::uint8_t i = 0; i < 4; ++i) device[i].num = i;
    count(1);
    send(0, item(31, 121, 5));
    EXPECT_EQ(ended(), MissionResult::denied);
    EXPECT_EQ(writes, 0);
    receive(Draft<"MISSION_CLEAR_ALL">{});
    EXPECT_EQ(ended(), MissionResult::unsupported);
}

TEST_F(Missions, are_uploaded_by_one_station_at_a_time) {
    count(2);
    count(2, {254, 190});
    EXPECT_EQ(sent.back().to, (Origin{254, 190}));
    EXPECT_EQ(ended(), MissionResult::denied);
    send(0, item(31, 121, 5), {254, 190});
    EXPECT_EQ(writes, 0);
    count(1);    // the same station begins again
    EXPECT_EQ(requested(), 0);
}

TEST_F(Missions, are_downloaded_in_both_forms) {
    device = {Waypoint{}, Waypoint{}};
    device[1] = {.num = 1, .lng = 121.5, .lat = 31.25, .alt = 750, .spd = 200, .yaw = 400, .fun = 1, .cmd = {9, 0, 0, 0}};
    receive(Draft<"MISSION_REQUEST_LIST">{});
    EXPECT_EQ(last<"MISSION_COUNT">().get<"count">(), 2);    // with a change of speed
    receive(Draft<"MISSION_REQUEST_INT">{}.set<"seq">(1));
    EXPECT_EQ(last<"MISSION_ITEM_INT">().get<"x">(), 312'500'000);
    EXPECT_EQ(last<"MISSION_ITEM_INT">().get<"param1">(), 9);
    EXPECT_FLOAT_EQ(last<"MISSION_ITEM_INT">().get<"z">(), 7.5F);
    receive(Draft<"MISSION_REQUEST">{}.set<"seq">(1), station, Version::v1);
    EXPECT_FLOAT_EQ(last<"MISSION_ITEM">().get<"x">(), 31.25F);
    receive(Draft<"MISSION_REQUEST_INT">{}.set<"seq">(2));
    EXPECT_EQ(ended(), MissionResult::invalid_sequence);
    error = "timed out";
    receive(Draft<"MISSION_REQUEST_LIST">{});
    EXPECT_EQ(ended(), MissionResult::error);
}

TEST_F(Missions, fences_and_rally_points_are_not_supported) {
    receive(Draft<"MISSION_COUNT">{}.set<"count">(3).set<"mission_type">(1));
    EXPECT_EQ(ended(), MissionResult::unsupported);
    receive(Draft<"MISSION_REQUEST_LIST">{}.set<"mission_type">(2));
    EXPECT_EQ(last<"MISSION_COUNT">().get<"count">(), 0);
    EXPECT_EQ(last<"MISSION_COUNT">().get<"mission_type">(), 2);
}

TEST_F(Missions, are_replaced_in_part) {
    count(3);
    for (int i = 0; i < 3; ++i) send(i, item(31, 121, static_cast<float>(i + 1)));
    receive(Draft<"MISSION_WRITE_PARTIAL_LIST">{}.set<"start_index">(1).set<"end_index">(1));
    EXPECT_EQ(requested(), 1);
    send(1, item(31, 121, 20));
    EXPECT_EQ(ended(), MissionResult::accepted);
    EXPECT_EQ(device.at(2).alt, 2000);
    EXPECT_EQ(device.at(3).alt, 300);
    receive(Draft<"MISSION_WRITE_PARTIAL_LIST">{}.set<"start_index">(1).set<"end_index">(7));
    EXPECT_EQ(ended(), MissionResult::invalid_sequence);
}

TEST_F(Missions, progress_is_shown_by_place) {
    count(3);
    send(0, item(31, 121, 5));
    send(1, speed(2));
    send(2, item(31.001, 121, 5));
    server.on_place(30, 121, 5);
    EXPECT_TRUE(sent_to_all.empty());
    server.on_place(31.000001, 121, 5.2);
    ASSERT_EQ(sent_to_all.size(), 2u);
    EXPECT_EQ(View<"MISSION_ITEM_REACHED">{sent_to_all[0].payload()}.get<"seq">(), 0);
    server.on_place(31.001, 121, 5);
    server.on_place(31.001, 121, 5);
    EXPECT_EQ(View<"MISSION_ITEM_REACHED">{sent_to_all.back().payload()}.get<"seq">(), 2);
    EXPECT_EQ(sent_to_all.size(), 3u);
    receive(Draft<"MISSION_SET_CURRENT">{}.set<"seq">(2));
    EXPECT_EQ(flown_from, std::vector<std::uint8_t>{2});
    receive(Draft<"MISSION_SET_CURRENT">{}.set<"seq">(9));
    EXPECT_EQ(ended(), MissionResult::invalid_sequence);
}

}    // namespace
}    // namespace mavlink_missions_tests
