// Devices over the control interface of a whole gateway: a simulated flight controller, several clients, a ground station.
#include <http/client/client.hpp>
#include <support/asked.hpp>
#include <support/fake_loader.hpp>
#include <support/http.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/sanitized.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <sys/unique_fd.hpp>

#include <ano/frame.hpp>
#include <ano/hex.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <future>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace devices_tests {
namespace {

using namespace support;
using anogate::http::Answer;
using anogate::http::Outcome;
using anogate::http::Request;
using nlohmann::json;

struct Told {
    unsigned status = 0;
    json body;
};

// 30 bytes/s: the command waits behind other frames.
TEST(DevicesOfASlowLink, a_command_that_waited_too_long_is_reported_as_not_sent) {
    const TempDir dir;
    const std::string socket = dir / "control.sock";
    PtyDevice device{dir / "fc"};
    Daemon daemon{ANOGATED, socket, {"serial:" + device.path() + ",name=fc,rate=30,age.rest=200ms"}};
    ASSERT_TRUE(daemon.until([&](const json& status) {
        device.write(frame(0xDC, 0xFF, 0x06, {0, 0, 0, 0, 0}));
        return !status.at("routes").empty();
    }));
    const Bytes text(40, 'x');
    for (int i = 0; i < 2; ++i) {
        const Bytes log = frame(0xFE, 0xDC, 0xA0, text);
        asked(socket, "POST", "/send", R"({"hex": ")" + ano::hex(log) + R"("})");
    }
    const Answer answer = asked(socket, "POST", "/devices/0xDC/commands/by-cid", R"({"cid": [16, 0, 2]})");
    EXPECT_EQ(answer.status, 503u) << answer.body;
    EXPECT_EQ(json::parse(answer.body).at("error"),
              "not sent: it waited too long in the queue of the link 'fc', which is too slow");
}

class Devices : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_TRUE(daemon.until_answers());
        ASSERT_TRUE(daemon.until([](const json& status) { return !status.at("routes").empty(); }));
    }
    Answer answer(const std::string& method, const std::string& target, const std::string& body = {},
                  const std::string& accept = {}) const {
        return asked(socket, method, target, body, accept);
    }
    Told ask(const std::string& method, const std::string& target, const std::string& body = {}) const {
        const Answer got = answer(method, target, body);
        return {got.status, json::parse(got.body, nullptr, false)};
    }
    std::vector<json> lines(const std::string& method, const std::string& target, const std::string& body = {}) const {
        const Answer got = answer(method, target, body, "application/x-ndjson");
        EXPECT_EQ(got.header("Content-Type"), "application/x-ndjson") << got.body;
        std::vector<json> all;
        std::istringstream stream{got.body};
        for (std::string line; std::getline(stream, line);) all.push_back(json::parse(line, nullptr, false));
        return all;
    }
    json value(const std::string& name) const { return ask("GET", "/devices/0xDC/parameters/" + name).body.at("value"); }

    // The file with the old values of a calibration; the digits in its name identify the unit.
    std::string kept_note() const {
        for (const auto& entry : std::filesystem::directory_iterator{dir / "state"})
            if (const std::string name = entry.path().filename(); name.starts_with("calibration-0xDC-")) return entry.path();
        return "none";
    }
    static bool has_named(const json& rows, const std::string& name) {
        return std::any_of(rows.begin(), rows.end(), [&](const json& row) { return row.at("name") == name; });
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    std::string config = dir.write("anogate.json", R"({"links": ["sim:fc", "udp-listen:127.0.0.1:0,name=ground"]})");
    Daemon daemon{ANOGATED, socket, {"--config", config}, {"STATE_DIRECTORY=" + (dir / "state")}};
    UdpPeer ground;
};

/// A device of the tests behind a listening UDP link.
struct UdpDevice {
    UdpDevice(std::uint16_t gateway, std::uint8_t address) : port{gateway} {
        fake.address = address;
        EXPECT_TRUE(peer.send(port, frame(address, 0xFF, 0x01, Bytes(13))));
    }
    /// Answers until the request that uses it has ended.
    Told serve(std::future<Told> waits) {
        while (waits.wait_for(std::chrono::milliseconds{1}) != std::future_status::ready)
            for (const Bytes& heard : peer.frames())
                for (const Bytes& answer : fake.take(ano::FrameView{heard})) peer.send(port, answer);
        return waits.get();
    }

    std::uint16_t port;
    UdpPeer peer;
    FakeDevice fake;
};

TEST_F(Devices, that_were_seen_are_listed) {
    const Told told = ask("GET", "/devices");
    EXPECT_EQ(told.status, 200u);
    ASSERT_EQ(told.body.at("devices").size(), 1u) << told.body;
    const json& fc = told.body.at("devices")[0];
    EXPECT_EQ(fc.at("address"), "0xDC");
    EXPECT_EQ(fc.at("link"), "fc");
    EXPECT_FALSE(fc.contains("name")) << "nobody asked yet";
    EXPECT_EQ(ask("GET", "/devices/0xDC/parameters").status, 200u);
    EXPECT_TRUE(ask("GET", "/devices").body.at("devices")[0].contains("name"));
}

TEST_F(Devices, parameters_are_read_and_written) {
    const Told all = ask("GET", "/devices/0xDC/parameters");
    ASSERT_EQ(all.status, 200u) << all.body;
    EXPECT_GT(all.body.at("parameters").size(), 30u);
    EXPECT_TRUE(has_named(all.body.at("parameters"), "SIM_HEIGHT")) << all.body;
    const Told written = ask("PUT", "/devices/0xDC/parameters/SIM_HEIGHT", R"({"value": 123})");
    EXPECT_EQ(written.status, 200u) << written.body;
    EXPECT_EQ(written.body.at("stored"), 123);
    EXPECT_EQ(value("SIM_HEIGHT"), 123);
    const Told clamped = ask("PUT", "/devices/0xDC/parameters/SIM_HEIGHT", R"({"value": 60000})");
    EXPECT_EQ(clamped.body.at("clamped"), true) << clamped.body;
    EXPECT_EQ(clamped.body.at("stored"), 10000);
    EXPECT_EQ(ask("PUT", "/devices/0xDC/parameters/SIM_HEIGHT", R"({"value": "high"})").status, 422u);
    EXPECT_EQ(ask("PUT", "/devices/0xDC/parameters/9999", R"({"value": 1})").status, 404u);
    EXPECT_EQ(ask("PUT", "/devices/0xDC/parameters/SIM_SERIAL", R"({"value": 1})").status, 504u)
        << "it does not even acknowledge";
}

TEST_F(Devices, applied_parameters_are_undone_when_one_fails) {
    const json before = value("SIM_TURN");
    const Told told = ask("POST", "/devices/0xDC/apply", R"({"parameters": {"SIM_TURN": 7, "SIM_SERIAL": 1}, "rollback": true})");
    EXPECT_EQ(told.status, 504u) << told.body;
    EXPECT_EQ(told.body.at("result").at("parameters")[0].at("state"), "undone") << told.body;
    EXPECT_EQ(value("SIM_TURN"), before);
    EXPECT_EQ(ask("POST", "/devices/0xDC/apply", R"({"SIM_TURN": 7})").status, 200u);
    EXPECT_EQ(value("SIM_TURN"), 7);
}

TEST_F(Devices, a_job_is_reported_line_by_line_and_stored) {
    const std::vector<json> all = lines("GET", "/devices/0xDC/parameters");
    ASSERT_GE(all.size(), 2u);
    EXPECT_EQ(all.front().at("state"), "running");
    EXPECT_EQ(all.back().at("state"), "done");
    EXPECT_GT(all.back().at("result").at("parameters").size(), 30u);
    const std::string path = "/jobs/" + std::to_string(all.back().at("id").get<int>());
    EXPECT_EQ(ask("GET", path).body, all.back());
    EXPECT_EQ(lines("GET", path), std::vector{all.back()});
    EXPECT_EQ(ask("GET", "/jobs").body.at("jobs").size(), 1u);
    EXPECT_EQ(ask("DELETE", path).body, all.back()) << "it was over";
    EXPECT_EQ(ask("POST", path + "/next").status, 409u);
    EXPECT_EQ(ask("GET", "/jobs/77").status, 404u);
}

// Two clients and a ground station, all with the same host address.
TEST_F(Devices, clients_with_the_same_address_each_receive_their_answers_and_none_waits_forever) {
    const std::uint16_t port = daemon.port("ground");
    const auto read = [&] { return ask("GET", "/devices/0xDC/parameters"); };
    auto one = std::async(std::launch::async, read), two = std::async(std::launch::async, read);
    std::set<int> answered;
    for (std::uint8_t id = 0; id < 10; ++id) {    // the ground station sends the same questions
        ASSERT_TRUE(ground.send(port, frame(0xFE, 0xDC, 0xE0, {2, id, 0})));
        EXPECT_TRUE(wait_until([&] {
            for (const Bytes& heard : ground.frames())
                if (ano::FrameView{heard}.id() == 0xE1) answered.insert(ano::FrameView{heard}.data()[0]);
            return answered.contains(id);
        })) << int{id};
    }
    const Told first = one.get(), second = two.get();
    EXPECT_EQ(first.status, 200u);
    EXPECT_EQ(second.status, 200u);
    EXPECT_EQ(first.body.at("parameters"), second.body.at("parameters"));
}

TEST_F(Devices, operations_do_not_change_the_routes_of_hosts) {
    const json before = ask("GET", "/routes").body;
    ASSERT_EQ(ask("GET", "/devices/0xDC/parameters").status, 200u);
    ASSERT_EQ(ask("PUT", "/devices/0xDC/parameters/SIM_TURN", R"({"value": 3})").status, 200u);
    const json after = ask("GET", "/routes").body;
    ASSERT_EQ(before.size(), after.size()) << after;
    EXPECT_EQ(before[0].at("address"), after[0].at("address"));
    EXPECT_EQ(before[0].at("links"), after[0].at("links"));
    EXPECT_EQ(before[0].at("via"), after[0].at("via"));
}

// Another host leaves alone the parameters that the ground station writes.
TEST_F(Devices, that_another_host_also_writes_are_written_and_the_conflict_is_reported) {
    ASSERT_EQ(ask("GET", "/devices").status, 200u);    // from now on its frames are observed
    const std::uint16_t port = daemon.port("ground");
    EXPECT_TRUE(wait_until([&] {
        EXPECT_TRUE(ground.send(port, frame(0xFE, 0xDC, 0xE1, {1, 0, 9})));
        const Told told = ask("PUT", "/devices/0xDC/parameters/SIM_HEIGHT", R"({"value": 500})");
        EXPECT_EQ(told.status, 200u) << told.body;
        return ask("GET", "/jobs").body.at("jobs").back().contains("conflict");
    }));
}

TEST_F(Devices, one_job_writes_at_a_time) {
    UdpPeer deaf;    // known to the gateway, but answers nothing
    ASSERT_TRUE(deaf.send(daemon.port("ground"), frame(0xDD, 0xFF, 0x01, Bytes(13))));
    ASSERT_TRUE(daemon.until([](const json& status) { return status.at("routes").size() == 2; }));
    auto first = std::async(std::launch::async,
                            [&] { return ask("PUT", "/devices/0xDD/parameters/X?client=one", R"({"value": 1})"); });
    ASSERT_TRUE(wait_until([&] { return !ask("GET", "/jobs").body.at("jobs").empty(); }));
    const Told second = ask("POST", "/devices/0xDD/apply", R"({"X": 1})");
    EXPECT_EQ(second.status, 409u);
    EXPECT_NE(second.body.at("error").get<std::string>().find(" (writing a parameter, by one ("), std::string::npos)
        << second.body;
    const std::string path = "/jobs/" + std::to_string(second.body.at("job").get<int>());
    EXPECT_EQ(ask("DELETE", path).body.at("state"), "cancelled");
    EXPECT_EQ(first.get().status, 409u);
}

TEST_F(Devices, a_job_with_while_connected_is_cancelled_when_its_client_disconnects) {
    UdpPeer deaf;
    ASSERT_TRUE(deaf.send(daemon.port("ground"), frame(0xDD, 0xFF, 0x01, Bytes(13))));
    ASSERT_TRUE(daemon.until([](const json& status) { return status.at("routes").size() == 2; }));
    const int client = connect_unix(socket);
    const std::string request = "GET /devices/0xDD/parameters?while_connected HTTP/1.1\r\n\r\n";
    ASSERT_EQ(::send(client, request.data(), request.size(), 0), static_cast<ssize_t>(request.size()));
    EXPECT_TRUE(wait_until([&] { return ask("GET", "/jobs").body.at("jobs").size() == 1; }));
    ::close(client);
    EXPECT_TRUE(wait_until([&] { return ask("GET", "/jobs").body.at("jobs")[0].at("state") == "cancelled"; }));
}

TEST_F(Devices, accept_commands_waypoints_and_actions) {
    const Told commands = ask("GET", "/devices/0xDC/commands");
    ASSERT_EQ(commands.status, 200u) << commands.body;
    EXPECT_TRUE(has_named(commands.body.at("commands"), "TAKE_OFF")) << commands.body;
    EXPECT_EQ(ask("POST", "/devices/0xDC/commands/TURN", R"({"values": [-5]})").status, 200u);
    EXPECT_EQ(value("SIM_TURN"), -5);
    EXPECT_EQ(ask("POST", "/devices/0xDC/commands/TURN", R"({"values": [500]})").status, 422u);
    EXPECT_EQ(ask("POST", "/devices/0xDC/actions", R"({"action": "save"})").status, 200u);
    const std::string two =
        R"({"waypoints": [{"lng": 116.4, "lat": 39.9, "alt": 0}, {"lng": 116.5, "lat": 39.8, "alt": 2500, "spd": 300, "yaw": 90}]})";
    EXPECT_EQ(ask("PUT", "/devices/0xDC/waypoints", two).body, (json{{"written", 2}}));
    const json back = ask("GET", "/devices/0xDC/waypoints").body.at("waypoints");
    EXPECT_EQ(back[1].at("alt"), 2500);
    const json map = ask("GET", "/devices/0xDC/waypoints?format=geojson").body;
    EXPECT_EQ(map.at("features").size(), back.size());
    const json plan = ask("GET", "/devices/0xDC/waypoints?format=qgc").body;
    EXPECT_EQ(ask("PUT", "/devices/0xDC/waypoints?format=qgc", plan.dump()).status, 200u);
    EXPECT_EQ(ask("GET", "/devices/0xDC/waypoints").body.at("waypoints"), back);
}

TEST_F(Devices, a_scan_reads_the_device_info) {
    const Told told = ask("POST", "/devices/scan");
    ASSERT_EQ(told.status, 200u) << told.body;
    ASSERT_EQ(told.body.at("devices").size(), 1u);
    EXPECT_EQ(told.body.at("devices")[0].at("name"), "SimFC");
    EXPECT_EQ(ask("GET", "/devices/SimFC/parameters/SIM_TURN").status, 200u);
}

TEST_F(Devices, firmware_is_written_however_large_the_file_is) {
    UdpDevice device{daemon.port("ground"), 0xDD};
    FakeLoader loader;
    device.fake.instead = [&](ano::FrameView f) { return loader.take(device.fake, f); };
    ASSERT_TRUE(daemon.until([](const json& status) { return status.at("routes").size() == 2; }));
    const std::string file(100'000, '\x01');
    const Told over = device.serve(std::async(std::launch::async, [&]() -> Told {
        const std::vector<json> all = lines("POST", "/devices/0xDD/firmware", file);
        return {200, all.empty() ? json{} : all.back()};
    }));
    EXPECT_EQ(over.body.at("state"), "done") << over.body;
    EXPECT_EQ(over.body.at("result").at("bytes"), 100'000);
    EXPECT_EQ(loader.flash.size(), file.size());
    EXPECT_EQ(ask("PUT", "/devices/0xDD/waypoints", std::string(100'000, ' ')).status, 413u) << "a body of another route";
}

TEST_F(Devices, a_file_of_64_mib_uses_little_memory_and_is_rejected_with_a_clear_error) {
    const long before = daemon.proc_status("VmHWM");
    const std::vector<json> all = lines("POST", "/devices/0xDC/firmware", std::string(std::size_t{64} << 20, ' '));
    ASSERT_FALSE(all.empty());
    EXPECT_EQ(all.back().at("state"), "failed");
    EXPECT_EQ(all.back().at("error"), "the image has more than 65536 frames of 195 bytes");
    const long more = daemon.proc_status("VmHWM") - before;
    RecordProperty("more_kb", std::to_string(more));
    EXPECT_LT(more, sanitized ? 512 * 1024 : 8 * 1024) << "kB";
    EXPECT_EQ(ask("POST", "/devices/0xDC/firmware", std::string((std::size_t{64} << 20) + 1, ' ')).status, 413u);
    EXPECT_TRUE(std::filesystem::is_empty(dir.path() / "state")) << "the file has no name";
}

TEST_F(Devices, a_calibration_waits_for_the_user_and_restores_the_old_values_when_cancelled) {
    const std::string what = R"({"what": "accelerometer"})";
    EXPECT_EQ(ask("POST", "/devices/0xDC/commands/TAKE_OFF", R"({"values": [100]})").status, 200u);
    const std::vector<json> flying = lines("POST", "/devices/0xDC/calibration", what);
    ASSERT_FALSE(flying.empty());
    EXPECT_EQ(flying.back().at("error"), "0xDC is unlocked or flying: this is only allowed on the ground");
    EXPECT_EQ(ask("POST", "/devices/0xDC/commands/LAND").status, 200u);
    const json before = value("CAL_AOFF_X");
    Told begun;
    ASSERT_TRUE(wait_until([&] { return (begun = ask("POST", "/devices/0xDC/calibration", what)).status == 202; }, 3 * patience))
        << begun.body;
    const std::string path = "/jobs/" + std::to_string(begun.body.at("id").get<int>());
    json job;
    ASSERT_TRUE(wait_until([&] { return (job = ask("GET", path).body).at("state") != "running"; }));
    ASSERT_EQ(job.at("state"), "waiting") << job;
    const std::string kept = kept_note();
    EXPECT_TRUE(std::filesystem::exists(kept));
    EXPECT_EQ(ask("POST", path + "/next").status, 200u);
    EXPECT_TRUE(wait_until([&] { return ask("GET", path).body.contains("step"); }));
    EXPECT_EQ(ask("DELETE", path).body.at("error"), "cancelled; the old values are restored");
    EXPECT_EQ(value("CAL_AOFF_X"), before);
    EXPECT_TRUE(wait_until([&] { return !std::filesystem::exists(kept); }));
}

// A request whose answer is read line by line as the lines arrive.
class Lines {
public:
    Lines(const std::string& socket, const std::string& head, const std::string& body = {}) : fd_{connect_unix(socket)} {
        const std::string text = head + " HTTP/1.1\r\nAccept: application/x-ndjson\r\nContent-Type: application/json\r\n" +
                                 "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
        EXPECT_EQ(::write(fd_.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
    }
    /// Waits for these words; false: the connection ended first.
    bool until(const std::string& words) {
        char room[4096];
        while (heard.find(words) == heard.npos) {
            const ssize_t n = ::read(fd_.get(), room, sizeof room);
            if (n <= 0) return false;
            heard.append(room, static_cast<std::size_t>(n));
        }
        return true;
    }
    std::string to_the_end() {
        until("\r\n0\r\n\r\n");
        return heard;
    }

    std::string heard;

private:
    anogate::UniqueFd fd_;
};

TEST_F(Devices, clients_that_follow_a_job_receive_its_end_when_the_gateway_stops) {
    UdpDevice device{daemon.port("ground"), 0xDD};    // it never answers
    ASSERT_TRUE(daemon.until([](const json& status) { return status.at("routes").size() == 2; }));
    Lines read{socket, "GET /devices/0xDD/parameters"}, idle{socket, "GET /jobs"};
    ASSERT_TRUE(read.until("running"));
    auto plain = std::async(std::launch::async, [&] { return ask("GET", "/devices/0xDD/parameters/1"); });
    ASSERT_TRUE(wait_until([&] { return ask("GET", "/jobs").body.at("jobs").size() == 2; }));
    const auto begin = std::chrono::steady_clock::now();
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, patience);
    const std::string last = read.to_the_end();
    EXPECT_NE(last.find(R"("state":"cancelled")"), last.npos) << last;
    EXPECT_NE(last.find("the gateway is stopping: cancelled"), last.npos) << last;
    EXPECT_TRUE(last.ends_with("\r\n0\r\n\r\n")) << "to the end of the answer: " << last;
    const Told told = plain.get();
    EXPECT_EQ(told.status, 503u);
    EXPECT_EQ(told.body.at("error"), "the gateway is stopping: cancelled");
}

TEST_F(Devices, old_values_of_an_interrupted_calibration_stay_in_a_file_if_the_unit_cannot_be_identified) {
    const json before = value("CAL_AOFF_X");
    Lines follows{socket, "POST /devices/0xDC/calibration", R"({"what": "accelerometer"})"};
    ASSERT_TRUE(follows.until(R"("state":"waiting")")) << follows.heard;
    const std::string kept = kept_note();
    EXPECT_EQ(
        ask("POST", "/jobs/" + std::to_string(ask("GET", "/jobs").body.at("jobs").back().at("id").get<int>()) + "/next").status,
        200u);
    ASSERT_TRUE(follows.until("lay it on")) << follows.heard;
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
    const std::string told = follows.to_the_end();
    EXPECT_NE(told.find("the old values are saved as calibration-0xDC-"), told.npos) << told;
    ASSERT_TRUE(std::filesystem::exists(kept));
    Daemon next{ANOGATED, socket, {"--config", config}, {"STATE_DIRECTORY=" + (dir / "state")}};
    ASSERT_TRUE(next.until_answers());
    EXPECT_TRUE(wait_until(
        [&] { return next.output().find("this unit can't be distinguished from others") != std::string::npos; }, 6 * patience))
        << next.output();
    EXPECT_NE(next.output().find("anoctl param import " + kept), std::string::npos) << next.output();
    EXPECT_TRUE(std::filesystem::exists(kept));
    EXPECT_EQ(value("CAL_AOFF_X"), before);
}

// The chip does not exist, so its switch counts as on.
TEST(DevicesAndRules, a_command_that_a_gpio_switch_blocks_is_rejected_at_once) {
    TempDir dir;
    const std::string socket = dir / "control.sock";
    const std::string config = dir.write("anogate.json", R"({"links": ["sim:fc"],
        "gpio": [{"chip": "no-such-chip", "line": 4, "use": "inhibit", "links": ["control"]}]})");
    Daemon daemon{ANOGATED, socket, {"--config", config}};
    ASSERT_TRUE(daemon.until_answers());
    ASSERT_TRUE(daemon.until([](const json& status) { return !status.at("routes").empty(); }));
    Request request;
    request.method = "POST";
    request.target = "/devices/0xDC/commands/LAND";
    const Outcome refused = anogate::http::ask(socket, request);
    EXPECT_EQ(refused.answer.status, 403u) << refused.answer.body;
    EXPECT_NE(refused.answer.body.find("GPIO"), std::string::npos) << refused.answer.body;
    request.method = "GET";
    request.target = "/devices/0xDC/parameters";
    EXPECT_EQ(anogate::http::ask(socket, request).answer.status, 200u) << "asking moves nothing";
}

// Rules of the link `control` apply to this host as well.
TEST(DevicesAndRules, a_write_that_the_rules_deny_is_rejected_at_once) {
    TempDir dir;
    const std::string socket = dir / "control.sock";
    const std::string config = dir.write(
        "anogate.json", R"({"links": ["sim:fc"], "control": {"receive": {"deny": ["parameter_value"]}, "host": "0xD2"}})");
    Daemon daemon{ANOGATED, socket, {"--config", config}};
    ASSERT_TRUE(daemon.until_answers());
    ASSERT_TRUE(daemon.until([](const json& status) { return !status.at("routes").empty(); }));
    Request request;
    request.method = "PUT";
    request.target = "/devices/0xDC/parameters/SIM_TURN";
    request.body = R"({"value": 1})";
    const Outcome outcome = anogate::http::ask(socket, request);
    EXPECT_EQ(outcome.answer.status, 403u) << outcome.answer.body;
    EXPECT_NE(outcome.answer.body.find("control.receive"), std::string::npos) << outcome.answer.body;
    EXPECT_EQ(daemon.status().at("routes").size(), 1u) << "it teaches no address";
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
}

}    // namespace
}    // namespace devices_tests
