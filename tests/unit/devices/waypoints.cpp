// Waypoints through the routes, in all their forms; and a scan.
#include <devices/waypoint_forms.hpp>
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

namespace waypoints_tests {
namespace {

using namespace support;
using anogate::WaypointForm;
using json = nlohmann::ordered_json;

struct WaypointRoutes : testing::Test {
    SimulatedNet net;
    FakeDevice& fake = net.add();

    const std::string two =
        R"({"waypoints": [{"num": 0, "lng": 116.4, "lat": 39.9, "alt": 0, "spd": 0, "yaw": 0, "fun": 0, "cmd": [0, 0, 0, 0]},
        {"num": 1, "lng": -0.1275, "lat": 51.5072, "alt": -250, "spd": 300, "yaw": 400, "fun": 2, "cmd": [1, 2, 3, 4]}]})";
};

TEST_F(WaypointRoutes, are_written_and_read_back) {
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/waypoints", two).json, json::parse(R"({"written": 2})"));
    EXPECT_EQ(fake.waypoints.size(), 2u);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/waypoints").json, json::parse(two));
}

TEST_F(WaypointRoutes, are_unchanged_after_a_round_trip_in_every_complete_format) {
    net.ask("PUT", "/devices/0xDC/waypoints", two);
    const json map = net.ask("GET", "/devices/0xDC/waypoints?format=geojson").json;
    EXPECT_EQ(map.at("type"), "FeatureCollection");
    EXPECT_EQ(map.at("features")[1].at("geometry").at("coordinates"), json::parse("[-0.1275, 51.5072, -2.5]"));
    fake.waypoints.clear();
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/waypoints?format=geojson", map.dump()).status, 200u);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/waypoints").json, json::parse(two));
}

TEST_F(WaypointRoutes, a_plan_contains_position_speed_and_yaw) {
    net.ask("PUT", "/devices/0xDC/waypoints", two);
    const json plan = net.ask("GET", "/devices/0xDC/waypoints?format=qgc").json;
    EXPECT_EQ(plan.at("fileType"), "Plan");
    EXPECT_EQ(plan.at("mission").at("plannedHomePosition"), json::parse("[39.9, 116.4, 0.0]"));
    ASSERT_EQ(plan.at("mission").at("items").size(), 2u) << "the speed first";
    EXPECT_EQ(plan.at("mission").at("items")[1].at("params"), json::parse("[0, 0, 0, null, 51.5072, -0.1275, -2.5]"));
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/waypoints?format=qgc", plan.dump()).status, 200u);
    const json back = net.ask("GET", "/devices/0xDC/waypoints").json.at("waypoints")[1];
    EXPECT_EQ(back.at("spd"), 300);
    EXPECT_EQ(back.at("yaw"), 400);
    EXPECT_EQ(back.at("alt"), -250);
    EXPECT_EQ(back.at("fun"), 0) << "a plan has no word for it";
}

TEST_F(WaypointRoutes, that_are_invalid_are_never_sent) {
    const std::pair<const char*, const char*> wrong[]{
        {"", R"({})"},
        {"", R"({"waypoints": [{"lng": 1}]})"},
        {"", R"({"waypoints": [5]})"},
        {"", R"({"waypoints": [{"lng": 1, "lat": 2, "alt": 3, "spd": 70000}]})"},
        {"", R"({"waypoints": [{"lng": 1, "lat": 2, "alt": 3, "spd": 1.5}]})"},
        {"", R"({"waypoints": [{"lng": 1, "lat": 2, "alt": 3, "cmd": [1]}]})"},
        {"", R"({"waypoints": [{"lng": 1, "lat": 91, "alt": 3}]})"},
        {"?format=geojson", R"({"features": [{"geometry": {"type": "LineString"}}]})"},
        {"?format=geojson", R"({"features": [5]})"},
        {"?format=geojson", R"({"features": [{"geometry": {"type": "Point", "coordinates": ["a", 1]}}]})"},
        {"?format=qgc", R"({"mission": {"items": []}})"},
        {"?format=qgc", R"({"mission": {"plannedHomePosition": [1, 2, 3], "items": [{"command": 22, "params": []}]}})"},
        {"?format=qgc", R"({"mission": {"plannedHomePosition": [1, 2, 3], "items": [{"command": 16, "params": [1]}]}})"},
    };
    for (const auto& [query, body] : wrong)
        EXPECT_EQ(net.ask("PUT", "/devices/0xDC/waypoints" + std::string{query}, body).status, 422u) << body;
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/waypoints?format=kml", two).status, 400u);
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/waypoints", "[]").status, 400u);
    EXPECT_TRUE(fake.waypoints.empty());
}

TEST_F(WaypointRoutes, are_rejected_with_the_fault_and_its_location) {
    const auto fault = [](WaypointForm form, const char* text) {
        const auto read = anogate::waypoints_in(json::parse(text), form);
        const auto* wrong = std::get_if<std::string>(&read);
        return wrong != nullptr ? *wrong : "nothing is wrong";
    };
    const auto plain = [&](const char* text) { return fault(WaypointForm::plain, text); };
    EXPECT_EQ(plain(R"({"waypoints": [{"lng": 1, "lat": 2, "alt": 0}, {"lng": 1, "lat": 2, "altitude": 500}]})"),
              "waypoint 1 (counted from 0): unknown key 'altitude' (did you mean 'alt'?)");
    EXPECT_EQ(plain(R"({"waypoints": [{"longitude": 1}]})"),
              "waypoint 0 (counted from 0): unknown key 'longitude' (did you mean 'lng'?)");
    EXPECT_EQ(plain(R"({"waypoints": [{"name": 1}]})"), "waypoint 0 (counted from 0): unknown key 'name'");
    EXPECT_EQ(plain(R"({"waypoints": [{"lng": 1, "lat": 2}]})"),
              "waypoint 0 (counted from 0): 'alt' is missing, its height in cm");
    EXPECT_EQ(plain(R"({"waypoints": [{"lng": 1, "lat": 2, "alt": 1, "num": 1}, {"lng": 1, "lat": 2, "alt": 1}]})"),
              "waypoint 1 (counted from 0): duplicate number 1");
    EXPECT_EQ(plain(R"({"waypoints": [{"lng": 1, "lat": 2, "alt": 1, "spd": 70000}]})"),
              "waypoint 0 (counted from 0): 'spd' is out of range, 0 to 65535");
    std::string many = R"({"lng": 1, "lat": 2, "alt": 1})";
    for (int i = 0; i < 255; ++i) many += R"(, {"lng": 1, "lat": 2, "alt": 1})";
    EXPECT_EQ(plain((R"({"waypoints": [)" + many + "]}").c_str()),
              "there are more than 255 waypoints: the last number of the protocol is 254");
    const auto map = [&](const char* text) { return fault(WaypointForm::geojson, text); };
    const std::string point = R"({"features": [{"geometry": {"type": "Point", "coordinates": [1, 2)";
    EXPECT_EQ(
        map((point + "]}}]}").c_str()),
        "feature 0 (counted from 0) has no height: add metres as the third of 'coordinates', or 'alt' in cm to its properties");
    EXPECT_EQ(map((point + R"(]}, "properties": {"alt": 5, "name": "x", "marker-color": "#f00"}}]})").c_str()),
              "nothing is wrong");
    EXPECT_EQ(map((point + R"(, 3]}, "properties": {"speed": 5}}]})").c_str()),
              "feature 0 (counted from 0): unknown key 'speed' (did you mean 'spd'?)");
    const auto plan = [&](const std::string& command) {
        return fault(WaypointForm::qgc, (R"({"mission": {"plannedHomePosition": [1, 2, 3], "items": [{"command": )" + command +
                                         R"(, "params": []}]}})")
                                            .c_str());
    };
    EXPECT_EQ(plan("22"),
              "item 0 (counted from 0) is a takeoff (22), but devices support only waypoints (16) and speed changes (178): "
              "delete it from the plan, and use a device command instead");
    EXPECT_EQ(plan("99"),
              "item 0 (counted from 0) is something else, but devices support only waypoints (16) and speed changes (178): "
              "delete it from the plan");
}

TEST_F(WaypointRoutes, a_scan_sends_three_requests_to_all_devices) {
    net.add(0x30).name = "pod";
    const ano::TimePoint begin = net.time;
    const auto [status, all] = net.ask("POST", "/devices/scan", "{}");
    EXPECT_EQ(status, 200u);
    EXPECT_LE(net.time - begin, 1500ms);
    ASSERT_EQ(all.at("devices").size(), 2u);
    EXPECT_EQ(all.at("devices")[0].at("name"), "fake");
    EXPECT_EQ(all.at("devices")[1].at("name"), "pod");
    EXPECT_EQ(net.sent.size(), 3u);
    EXPECT_EQ(net.sent[0], frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    EXPECT_EQ(net.flushed_before, (std::vector<Bytes>{net.sent[1], net.sent[2]})) << "a device may be deaf to the first one";
    EXPECT_EQ(net.ask("GET", "/devices/pod/commands").status, 200u) << "it may be called by that name now";
    net.refuses[0xE0] = "no";
    EXPECT_EQ(net.ask("POST", "/devices/scan").status, 403u);
}

}    // namespace
}    // namespace waypoints_tests
