// The answers of a gateway on its control socket, for each row of its own table.
#include <support/asked.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <ano/messages.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <utility>

namespace control_interface_tests {
namespace {

using namespace support;
using anogate::http::Answer;
using nlohmann::json;

class ControlInterface : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_TRUE(daemon.until_answers());
        host.send(daemon.port("ground"), vendor::who_are_you);
        ASSERT_TRUE(daemon.until([](const json& status) { return !status.at("routes").empty(); }));
    }
    Answer ask(const std::string& method, const std::string& target, const std::string& body = {},
               const std::string& accept = {}) const {
        return asked(socket, method, target, body, accept);
    }
    json get(const std::string& target) const {
        const Answer answer = ask("GET", target);
        EXPECT_EQ(answer.status, 200u) << target;
        EXPECT_EQ(answer.header("Content-Type"), "application/json") << target;
        EXPECT_EQ(answer.body.find('\n'), answer.body.size() - 1) << target << " is one line";
        return json::parse(answer.body, nullptr, false);
    }
    /// Expects a refusal with this status, this `error` code, and a message that contains these words.
    void refuses(const std::string& method, const std::string& target, unsigned status, const std::string& what,
                 const std::string& words, const std::string& body = {}) const {
        const Answer answer = ask(method, target, body);
        EXPECT_EQ(answer.status, status) << method << " " << target;
        const json error = json::parse(answer.body, nullptr, false);
        ASSERT_TRUE(error.is_object()) << answer.body;
        EXPECT_EQ(error.at("what"), what) << answer.body;
        EXPECT_NE(error.at("error").get<std::string>().find(words), std::string::npos) << answer.body;
    }

    void list() const {
        const json all = get("/");
        EXPECT_EQ(all.at("name"), "anogate");
        EXPECT_TRUE(all.at("version").is_string());
        for (const json& row : all.at("routes")) {
            EXPECT_NE(row.at("answers"), "") << row << " does not say what it answers";
            const std::string path = row.at("path");
            const bool is_page = path == "/" || path == "/web/{file}";
            EXPECT_EQ(row.at("access") == "open", is_page || path == "/login" || path == "/logout") << row;
            EXPECT_EQ(row.at("access") == "view", row.at("method") == "GET" && path != "/link" && !is_page) << row;
        }
    }
    void status() const {
        const json now = get("/status");
        EXPECT_EQ(now.at("links").size(), 2u);
        const json& absent = now.at("links").at(1);
        EXPECT_EQ(absent.at("hint"), "");
        EXPECT_EQ(absent.at("hint_id"), "");
        EXPECT_EQ(absent.at("hint_args"), json::object());
    }
    void links() const {
        json links = get("/links"), from_status = get("/status").at("links");
        ASSERT_EQ(links.size(), 2u);
        EXPECT_EQ(links[0].at("name"), "ground");
        std::set<std::string> keys, status_keys;
        for (const auto& [key, value] : links[0].items()) keys.insert(key);
        for (const auto& [key, value] : from_status[0].items()) status_keys.insert(key);
        EXPECT_EQ(keys, status_keys);
    }
    void routes() const {
        const json routes = get("/routes");
        ASSERT_EQ(routes.size(), 2u) << routes;
        EXPECT_EQ(routes[0].at("address"), "0x07");
        EXPECT_EQ(routes[0].at("via"), "port");
        EXPECT_EQ(routes[1].at("address"), "0xFE");
        EXPECT_EQ(routes[1].at("via"), "learned");
    }
    void forget() const {
        refuses("DELETE", "/routes/0xDC", 404, "unknown", "0xDC was not seen");
        refuses("DELETE", "/routes/nobody", 400, "invalid", "'nobody'");
        refuses("DELETE", "/routes/300", 400, "invalid", "300");
        const Answer answer = ask("DELETE", "/routes/host");
        EXPECT_EQ(answer.status, 200u);
        EXPECT_EQ(json::parse(answer.body), (json{{"address", "0xFE"}, {"forgotten", true}}));
        EXPECT_EQ(get("/routes").size(), 1u);
        refuses("DELETE", "/routes/254", 404, "unknown", "0xFE was not seen");
    }
    void log() {
        host.send(daemon.port("ground"), frame(0xDC, 0xFF, 0xA0, {1, 'b', 'a', 'd'}));
        const auto lines = [&] { return get("/devices/0xDC/log").at("lines"); };
        ASSERT_TRUE(wait_until([&] { return !lines().empty(); }));
        const json line = lines()[0];
        EXPECT_EQ(line.at("text"), "bad");
        EXPECT_EQ(line.at("color"), 1);
        EXPECT_EQ(line.at("link"), "ground");
        EXPECT_EQ(line.value("counts", true), false) << "who asks by UDP may say so in any device's name";
        EXPECT_EQ(get("/devices/0xDC/log").at("red"), 0);
        EXPECT_EQ(get("/devices/0xFF/log").at("lines").size(), 1u);
        EXPECT_TRUE(get("/devices/0xDC/log?since=4000000000").at("lines").empty());
        for (const char* wrong : {"x", "NaN", "-inf", "1e999"})
            refuses("GET", std::string{"/devices/0xFF/log?since="} + wrong, 400, "invalid", "'since'");
        ask("DELETE", "/routes/0xDC");
    }
    void limits() const {
        const std::string body = R"({"limits": [{"field": "power.voltage", "side": "below", "red": 3.4, "cells": 4}]})";
        const json kept = json::parse(ask("PUT", "/devices/0xDC/limits", body).body);
        EXPECT_EQ(kept.at("limits"), json::parse(body).at("limits"));
        EXPECT_EQ(kept.at("kept"), true) << kept;
        EXPECT_EQ(get("/devices/0xDC/limits").at("version"), kept.at("version"));
        refuses("PUT", "/devices/0xDC/limits", 422, "invalid", "'side'", R"({"limits": [{"field": "a.b"}]})");
        refuses("PUT", "/devices/0xFF/limits", 400, "invalid", "one device", body);
        ask("PUT", "/devices/0xDC/limits", R"({"limits": []})");
        EXPECT_EQ(get("/devices/0xDC/limits").at("version"), 0);
    }
    void alarms() {
        EXPECT_TRUE(get("/alarms").at("alarms").empty());
        ask("PUT", "/devices/0xDC/limits",
            R"({"limits": [{"field": "power.voltage", "side": "below", "amber": 14.4, "red": 13.6}]})");
        host.send(daemon.port("ground"), frame(0xDC, 0xFF, 0x0D, {0x28, 0x05, 0, 0}));    // 13.2 V
        ASSERT_TRUE(wait_until([&] { return !get("/alarms").at("alarms").empty(); }));
        const json alarm = get("/alarms").at("alarms").at(0);
        EXPECT_EQ(alarm.at("device"), "0xDC");
        EXPECT_EQ(alarm.at("level"), "red");
        EXPECT_EQ(alarm.at("value"), 13.2);
        EXPECT_EQ(alarm.at("unit"), "V");
        const std::string counted = ask("GET", "/metrics").body;
        EXPECT_NE(counted.find("\nanogate_alarms{level=\"amber\"} 0\n"), std::string::npos);
        EXPECT_NE(counted.find("\nanogate_alarms{level=\"red\"} 1\n"), std::string::npos);
        ask("DELETE", "/routes/0xDC");    // the device was switched off
        EXPECT_TRUE(get("/alarms").at("alarms").empty());
        ask("PUT", "/devices/0xDC/limits", R"({"limits": []})");
    }
    void messages() const {
        const json rows = get("/messages");
        EXPECT_EQ(rows.size(), ano::messages.size());
        const auto flexible = std::find_if(rows.begin(), rows.end(), [](const json& row) { return row.at("id") == 0xF1; });
        ASSERT_NE(flexible, rows.end());
        EXPECT_EQ(flexible->at("fields").at(0).at("name"), "water_temp") << "as it is configured";
    }
    void metrics() const {
        const Answer text = ask("GET", "/metrics");
        EXPECT_EQ(text.header("Content-Type"), "text/plain; version=0.0.4; charset=utf-8");
        EXPECT_NE(text.body.find("\nanogate_link_frames_in_total{link=\"ground\"} 1\n"), std::string::npos) << text.body;
        EXPECT_EQ(text.body.find("# EOF"), std::string::npos);
        const Answer open = ask("GET", "/metrics", {}, "application/openmetrics-text;version=1.0.0");
        EXPECT_EQ(open.header("Content-Type"), "application/openmetrics-text; version=1.0.0; charset=utf-8");
        EXPECT_TRUE(open.body.ends_with("\n# EOF\n"));
    }
    void gpio() const {
        refuses("POST", "/gpio", 404, "unknown", "no GPIO line matches", "{}");
        refuses("POST", "/gpio", 400, "invalid", "unknown key 'lien'", R"({"lien": 3})");
    }
    void recordings() const {
        const json all = get("/recordings");
        EXPECT_EQ(all.at("folder"), socket + ".state/recordings");
        EXPECT_EQ(all.at("recordings"), json::array());
        EXPECT_EQ(all.at("running"), json::array());
        EXPECT_EQ(all.at("keep_last"), json());
        EXPECT_TRUE(all.at("free_bytes").is_number());
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    std::string config = dir.write("anogate.json", R"({"links": ["udp-listen:127.0.0.1:0,name=ground,id=7", "serial:/dev/absent"],
        "flexible": [{"id": "0xF1", "fields": [{"name": "water_temp", "type": "i16", "scale": 0.1, "unit": "°C"}]}]})");
    Daemon daemon{ANOGATED, socket, {"--config", config}};
    UdpPeer host;
};

// A new route needs a test here, or a reference to its test elsewhere.
TEST_F(ControlInterface, answers_every_route_of_its_list) {
    const std::pair<std::string, std::function<void()>> tests[]{
        {"GET /", [this] { list(); }},
        {"GET /web/{file}", [this] { refuses("GET", "/web/none.js", 404, "unknown", "no such file"); }},    // Page
        {"GET /status", [this] { status(); }},
        {"GET /links", [this] { links(); }},
        {"GET /routes", [this] { routes(); }},
        {"DELETE /routes/{address}", [this] { forget(); }},
        {"GET /messages", [this] { messages(); }},
        {"GET /metrics", [this] { metrics(); }},
        {"GET /map.pmtiles", [this] { refuses("GET", "/map.pmtiles", 404, "unknown", "control.map"); }},    // Map
        {"POST /gpio", [this] { gpio(); }},
        {"POST /send", [this] { refuses("POST", "/send", 400, "invalid", "hex", R"({"hex": "5"})"); }},      // ControlLink
        {"GET /frames", [this] { refuses("GET", "/frames?direktion=in", 400, "invalid", "direction"); }},    // Frames
        {"GET /foxglove", [this] { refuses("GET", "/foxglove", 426, "unsupported", "WebSocket"); }},         // Foxglove
        {"GET /links/{link}/raw",
         [this] { refuses("GET", "/links/ground/raw", 426, "unsupported", "WebSocket"); }},     // RawBytes
        {"GET /link", [this] { refuses("GET", "/link", 426, "unsupported", "WebSocket"); }},    // ControlLink
        {"POST /reload",
         [this] { EXPECT_EQ(json::parse(ask("POST", "/reload?dry_run").body).at("changed"), false); }},    // Reload
        {"POST /reload/confirm", [this] { refuses("POST", "/reload/confirm", 409, "refused", "no configuration is waiting"); }},
        {"GET /flexible", [this] { EXPECT_EQ(get("/flexible").at("flexible").at(0).at("id"), "0xF1"); }},    // Flexible
        {"PUT /flexible", [this] { refuses("PUT", "/flexible", 400, "invalid", "a list of layouts", "5"); }},
        {"GET /devices",
         [this] {
             EXPECT_EQ(get("/devices"), (json{{"devices", json::array()}}));
         }},    // Devices, like all that follow
        {"GET /devices/{device}/limits", [this] { refuses("GET", "/devices/nobody/limits", 404, "unknown", "'nobody'"); }},
        {"PUT /devices/{device}/limits", [this] { limits(); }},
        {"GET /devices/{device}/parameters",
         [this] { refuses("GET", "/devices/0xDC/parameters", 404, "unknown", "0xDC was not seen"); }},
        {"GET /devices/{device}/parameters/{parameter}",
         [this] { refuses("GET", "/devices/nobody/parameters/P", 404, "unknown", "'nobody'"); }},
        {"PUT /devices/{device}/parameters/{parameter}",
         [this] { refuses("PUT", "/devices/0xDC/parameters/P", 400, "invalid", "'value'", "{}"); }},
        {"POST /devices/{device}/apply", [this] { refuses("POST", "/devices/0xDC/apply", 400, "invalid", "not JSON", "{"); }},
        {"POST /devices/scan",
         [this] {
             const json nobody{{"devices", json::array()}};
             EXPECT_EQ(json::parse(ask("POST", "/devices/scan").body), nobody);
         }},
        {"POST /devices/{device}/actions", [this] { refuses("POST", "/devices/0xDC/actions", 400, "invalid", "save", "{}"); }},
        {"GET /devices/{device}/commands", [this] { refuses("GET", "/devices/0xDC/commands", 404, "unknown", "was not seen"); }},
        {"POST /devices/{device}/commands/by-cid",
         [this] { refuses("POST", "/devices/0xDC/commands/by-cid", 400, "invalid", "'cid'", R"({"cid": [1, 2]})"); }},
        {"POST /devices/{device}/commands/{command}",
         [this] { refuses("POST", "/devices/0xDC/commands/C", 400, "invalid", "'values'", R"({"values": 1})"); }},
        {"GET /devices/{device}/waypoints",
         [this] { refuses("GET", "/devices/0xDC/waypoints?format=kml", 400, "invalid", "'format'"); }},
        {"PUT /devices/{device}/waypoints",
         [this] { refuses("PUT", "/devices/0xDC/waypoints", 422, "invalid", "'waypoints' must be an array", "{}"); }},
        {"POST /devices/{device}/firmware",
         [this] { refuses("POST", "/devices/0xDC/firmware?crc=none", 400, "invalid", "'none'", "x"); }},
        {"POST /devices/{device}/calibration",
         [this] { refuses("POST", "/devices/0xDC/calibration", 400, "invalid", "compass", "{}"); }},
        {"GET /jobs",
         [this] {
             const json jobs = get("/jobs").at("jobs");    // includes the jobs for an unknown device
             EXPECT_TRUE(std::any_of(jobs.begin(), jobs.end(), [](const json& job) { return job.at("kind") == "scan"; })) << jobs;
         }},
        {"GET /jobs/{job}", [this] { refuses("GET", "/jobs/7", 404, "unknown", "there is no job '7'"); }},
        {"DELETE /jobs/{job}", [this] { refuses("DELETE", "/jobs/x", 404, "unknown", "'x'"); }},
        {"POST /jobs/{job}/next", [this] { refuses("POST", "/jobs/7/next", 404, "unknown", "there is no job"); }},
        {"GET /devices/{device}/log", [this] { log(); }},
        {"GET /alarms", [this] { alarms(); }},
        {"GET /recordings", [this] { recordings(); }},    // Recordings, like all that follow
        {"POST /recordings", [this] { refuses("POST", "/recordings", 422, "invalid", "'nmae'", R"({"nmae": "x"})"); }},
        {"GET /recordings/last", [this] { refuses("GET", "/recordings/last", 409, "busy", "keep_last"); }},
        {"GET /recordings/{name}", [this] { refuses("GET", "/recordings/none.pcapng", 404, "unknown", "no recording"); }},
        {"POST /recordings/{name}/end",
         [this] { refuses("POST", "/recordings/none/end", 404, "unknown", "no recording with that name"); }},
        {"DELETE /recordings/{name}", [this] { refuses("DELETE", "/recordings/%2e.", 422, "invalid", "no leading dot"); }},
        {"POST /login", [this] { refuses("POST", "/login", 400, "invalid", "token", "{}"); }},    // NetworkListener
        {"POST /login/code", [this] { refuses("POST", "/login/code", 409, "busy", "no token allows", "{}"); }},    // SignInCodes
        {"POST /logout", [this] { EXPECT_EQ(ask("POST", "/logout").status, 200u); }},                              // Tokens
    };
    std::set<std::string> tested, there;
    for (const auto& [route, test] : tests) {
        SCOPED_TRACE(route);
        tested.insert(route);
        test();
    }
    const json listed = get("/");
    for (const json& row : listed.at("routes"))
        there.insert(row.at("method").get<std::string>() + " " + row.at("path").get<std::string>());
    EXPECT_EQ(tested, there);
}

TEST_F(ControlInterface, reports_all_errors_in_one_form) {
    refuses("GET", "/statsu", 404, "unknown", "did you mean '/status'?");
    refuses("POST", "/status", 405, "unsupported", "only GET, HEAD");
    refuses("GET", "/status?a=%", 400, "invalid", "the query has a %");
    refuses("POST", "/gpio", 413, "invalid", "65536", std::string(70'000, ' '));
}

}    // namespace
}    // namespace control_interface_tests
