// anogate-mqtt beside a gateway and a mosquitto.
#include "mosquitto.hpp"

#include <ano/hex.hpp>
#include <support/bytes.hpp>
#include <support/namespaces.hpp>
#include <support/udp_peer.hpp>

#include <nlohmann/json.hpp>

#include <sched.h>
#include <sys/mount.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <random>
#include <set>
#include <thread>

namespace program_tests {
namespace {

using namespace anogate;
using namespace mqtt_tests;
using support::Bytes;
using Json = nlohmann::json;

constexpr std::uint8_t euler_id = 0x03;

Bytes numbered_angles(std::uint64_t number) {
    return {static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8), 0, 0, 0, 0, 1};
}
/// The number in a record; 0: it is another message.
std::uint64_t number_in(const Json& record) {
    if (!record.is_object() || record.value("name", "") != "euler") return 0;
    return static_cast<std::uint16_t>(std::llround(record["fields"]["rol"].get<double>() * 100));
}

class MqttProgram : public testing::Test {
protected:
    void SetUp() override { ANOGATE_NEEDS_MOSQUITTO(); }

    void start_gateway() {
        gateway = std::make_unique<support::Daemon>(
            ANOGATED, socket, std::vector{device.link("fc"), std::string{"--log-level"}, std::string{"warn"}});
        ASSERT_TRUE(gateway->until_answers()) << gateway->output();
        port = gateway->port("fc");
    }
    /// `keys`: of the configuration, after "broker".
    void start_program(
        const std::string& broker, const std::string& keys = R"("messages": [{"message": "*", "rate": 0}])",
        const std::function<void()>& in_child = [] {}) {
        const std::string file = dir.write("mqtt.json", R"({"broker": ")" + broker +
                                                            R"(", "name": "g", "will_delay": "0s", "spool": ")" + dir / "spool" +
                                                            "\", " + keys + "}");
        program = std::make_unique<support::Process>(
            ANOGATE_MQTT, std::vector<std::string>{"--control", socket, "--config", file}, std::vector<std::string>{}, in_child);
    }
    bool until_connected() {
        return program->until_says("connected to the broker") && program->until_says("connected to the gateway");
    }
    void send(std::uint64_t one) { device.send(port, support::frame(5, 0xFE, euler_id, numbered_angles(one))); }
    bool send_until(const std::function<bool()>& holds) {
        return support::wait_until(
            [&] {
                send(++number);
                return holds();
            },
            support::patience, [] { std::this_thread::sleep_for(10ms); });
    }
    std::string stop_program() {
        program->signal(SIGTERM);
        EXPECT_EQ(program->wait(), 0) << program->output();
        return program->output();
    }

    support::TempDir dir;
    std::string socket = dir / "control.sock";
    support::UdpPeer device;
    std::uint16_t port = 0;
    std::uint64_t number = 0;
    std::unique_ptr<support::Daemon> gateway;
    std::unique_ptr<support::Process> program;
};

TEST_F(MqttProgram, publishes_a_birth_telemetry_raw_frames_and_a_farewell) {
    Mosquitto mosquitto;
    start_gateway();
    Client reader{mosquitto.port(), "reader", {{"anogate/v1/#", 1}}};
    start_program(mosquitto.address(), R"("raw": true, "messages": [{"message": "*", "rate": 0}])");
    ASSERT_TRUE(until_connected());
    ASSERT_TRUE(send_until([&] { return reader.payloads("anogate/v1/g/up/fc-05/euler").size() >= 3; }));
    const Json record = Json::parse(reader.payloads("anogate/v1/g/up/fc-05/euler")[0]);
    EXPECT_EQ(record["gateway"], "g");
    EXPECT_EQ(record["link"], "fc");
    EXPECT_GT(record["boottime"], 0);
    EXPECT_GT(number_in(record), 0u);
    const auto raw = reader.payloads("anogate/v1/g/raw/up");
    ASSERT_FALSE(raw.empty());
    EXPECT_EQ(static_cast<std::uint8_t>(raw[0][0]), 0xAB);
    const Json birth = Json::parse(reader.payloads("anogate/v1/g/status").at(0));
    EXPECT_EQ(birth["state"], "online");
    EXPECT_EQ(birth["why"], "restart");
    EXPECT_EQ(birth["run"], record["stream"]);
    ASSERT_TRUE(support::wait_until([&] { return reader.payloads("anogate/v1/g/status").size() >= 2; })) << "a device was heard";
    EXPECT_EQ(Json::parse(reader.payloads("anogate/v1/g/status")[1])["devices"][0]["device"], "fc-05");
    EXPECT_NE(stop_program().find(" 0 dropped, 0 frames lost"), std::string::npos) << program->output();
    ASSERT_TRUE(support::wait_until([&] {
        const auto all = reader.payloads("anogate/v1/g/status");
        return Json::parse(all.back())["why"] == "stopped";
    }));
    Client late{mosquitto.port(), "late", {{"anogate/v1/+/status", 1}}};
    ASSERT_TRUE(late.until_messages(1));
    EXPECT_TRUE(late.messages()[0].is_retained);
}

TEST_F(MqttProgram, a_killed_program_leaves_a_will_and_its_next_birth_says_restart) {
    Mosquitto mosquitto;
    start_gateway();
    Client reader{mosquitto.port(), "reader", {{"anogate/v1/+/status", 1}}};
    const auto last = [&](const std::string& key) {
        const auto all = reader.payloads("anogate/v1/g/status");
        return all.empty() ? Json{} : Json::parse(all.back())[key];
    };
    start_program(mosquitto.address());
    ASSERT_TRUE(support::wait_until([&] { return last("state") == "online"; }));
    const Json run = last("run");
    program->signal(SIGKILL);
    ASSERT_TRUE(support::wait_until([&] { return last("state") == "offline"; }));
    EXPECT_EQ(last("run"), run);
    EXPECT_EQ(last("connection"), 1);
    start_program(mosquitto.address());
    ASSERT_TRUE(support::wait_until([&] { return last("state") == "online"; }));
    EXPECT_EQ(last("why"), "restart");
    mosquitto.kill();
    mosquitto.start();
    ASSERT_TRUE(support::wait_until([&] { return last("why") == "connection"; }));
    EXPECT_EQ(last("connection"), 2);
}

struct Requester {
    explicit Requester(std::uint16_t port) : client{port, "shore", {{"anogate/v1/g/response/#", 1}}} {
        std::this_thread::sleep_for(100ms);    // until the subscription is active
    }
    void ask(const Json& request, std::uint32_t expiry_s = 10, bool is_retained = false) {
        client.broker().publish({.topic = "anogate/v1/g/request/shore",
                                 .payload = request.dump(),
                                 .is_retained = is_retained,
                                 .expiry_s = expiry_s,
                                 .correlation = "c" + std::to_string(++asked)});
    }
    /// The response to the last request.
    Json response() {
        Json found;
        EXPECT_TRUE(support::wait_until([&] {
            for (const auto& message : client.messages())
                if (message.correlation == "c" + std::to_string(asked)) found = Json::parse(message.payload);
            return !found.is_null();
        }));
        return found;
    }

    int asked = 0;
    Client client;
};

TEST_F(MqttProgram, requests_are_executed_once_per_key_even_over_restarts_of_broker_and_program) {
    Mosquitto mosquitto;
    start_gateway();
    start_program(mosquitto.address(), R"("allow": ["POST /send"])");
    ASSERT_TRUE(until_connected());
    ASSERT_TRUE(support::wait_until([&] { return send(1), gateway->count("fc", "frames_in") > 0; }));
    Requester shore{mosquitto.port()};
    shore.ask({{"target", "/devices"}});
    const Json devices = shore.response();
    EXPECT_EQ(devices["status"], 200);
    EXPECT_TRUE(devices["body"]["devices"].is_array());
    shore.ask({{"method", "POST"}, {"target", "/reload"}, {"key", "r"}});
    EXPECT_EQ(shore.response()["status"], 403);

    device.forget();
    const Bytes frame = support::frame(0xFE, 5, 0xE0, {1, 2, 3});
    const Json request{{"method", "POST"}, {"target", "/send"}, {"key", "k1"}, {"body", {{"hex", ano::hex(frame)}}}};
    const auto executed = [&] {
        int count = 0;
        for (const Bytes& one : support::split(device.heard()).frames) count += one == frame ? 1 : 0;
        return count;
    };
    shore.ask(request);
    EXPECT_EQ(shore.response()["status"], 200) << shore.response().dump();
    ASSERT_TRUE(support::wait_until([&] { return executed() == 1; }));
    shore.ask(request);
    EXPECT_EQ(shore.response()["status"], 200);
    mosquitto.kill();
    mosquitto.start();
    ASSERT_TRUE(shore.client.until_connected(2));
    ASSERT_TRUE(support::wait_until([&] {
        return program->output().find("connected to the broker", program->output().find("connecting again")) != std::string::npos;
    }));
    shore.ask(request);
    EXPECT_EQ(shore.response()["status"], 200);
    program->signal(SIGKILL);
    program->wait();
    start_program(mosquitto.address(), R"("allow": ["POST /send"])");
    ASSERT_TRUE(until_connected());
    std::this_thread::sleep_for(100ms);    // until the subscription is active
    shore.ask(request);
    EXPECT_EQ(shore.response()["status"], 200);
    Json late = request;
    late["key"] = "k2";
    late["before"] = 1;    // second of the boot time
    shore.ask(late);
    EXPECT_EQ(shore.response()["status"], 408);
    EXPECT_EQ(executed(), 1);
    late.erase("before");
    shore.ask(late, 10, true);    // retained: the gateway is connected, so the broker delivers it as a usual message
    EXPECT_EQ(shore.response()["status"], 200);
    ASSERT_TRUE(support::wait_until([&] { return executed() == 2; }));
    program->signal(SIGKILL);
    program->wait();
    std::filesystem::remove_all(dir / "spool");
    start_program(mosquitto.address(), R"("allow": ["POST /send"])");
    EXPECT_EQ(shore.response()["status"], 200);
    ASSERT_TRUE(support::wait_until([&] {
        const auto all = shore.client.messages();
        return Json::parse(all.back().payload)["status"] == 400;
    })) << "now it is delivered as retained";
    EXPECT_EQ(executed(), 2);
}

TEST_F(MqttProgram, a_dead_network_or_resolver_costs_no_frame_of_the_gateway) {
    ANOGATE_NEEDS_NAMESPACES();
    for (const std::string& broker : {std::string{"10.9.0.2:1883"}, std::string{"broker.example:1883"}}) {
        const NetworkThatDrops net;
        support::UdpPeer vehicle;
        support::Daemon beside{ANOGATED, socket, {vehicle.link("fc"), "--log-level", "warn"}};
        ASSERT_TRUE(beside.until_answers());
        const std::string resolver = dir.write("resolv.conf", "nameserver 10.9.0.2\noptions timeout:30\n");
        start_program(broker, R"("messages": [{"message": "*", "rate": 0}])", [&] {
            ::unshare(CLONE_NEWNS);
            ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
            ::mount(resolver.c_str(), "/etc/resolv.conf", nullptr, MS_BIND, nullptr);
        });
        ASSERT_TRUE(program->until_says("connected to the gateway"));
        constexpr int frames = 3000;
        for (int i = 0; i < frames; ++i) {
            vehicle.send(beside.port("fc"), support::frame(5, 0xFE, euler_id, numbered_angles(static_cast<std::uint64_t>(i))));
            if (i % 10 == 0) std::this_thread::sleep_for(2ms);
        }
        ASSERT_TRUE(support::wait_until([&] { return beside.count("fc", "frames_in") >= frames; }));
        std::this_thread::sleep_for(300ms);    // of the stream of frames
        const std::string output = stop_program();
        EXPECT_NE(output.find("0 messages acknowledged, 3000 records in the spool, 0 dropped, 0 frames lost"), std::string::npos)
            << output;
        std::filesystem::remove_all(dir / "spool");
    }
}

/// The records at the reader: how often each number is there.
std::map<std::uint64_t, int> collected(const std::string& folder) {
    std::map<std::uint64_t, int> numbers;
    if (!std::filesystem::exists(folder)) return numbers;
    for (const auto& entry : std::filesystem::recursive_directory_iterator{folder}) {
        if (entry.path().extension() != ".ndjson") continue;
        std::ifstream file{entry.path()};
        for (std::string line; std::getline(file, line);) {
            const Json record = Json::parse(line, nullptr, false);
            if (const std::uint64_t number = number_in(record)) ++numbers[number];
        }
    }
    return numbers;
}

class MqttOutage : public MqttProgram {
protected:
    // With persistence of every change, mosquitto keeps what it acknowledged over kill -9, but for the last moment: it saves afterwards.
    static std::string persistent(const std::string& folder) {
        return "allow_anonymous true\nmax_queued_messages 0\npersistence true\npersistence_location " + folder +
               "/\nautosave_on_changes true\nautosave_interval 1\n";
    }
    void start_collector(const std::string& broker, std::vector<std::string> more = {}) {
        std::vector<std::string> words{
            "--config", dir.write("collect.json", "{}"), "--broker", broker, "--name", "c", "--collect", "--to", dir / "all"};
        words.insert(words.end(), more.begin(), more.end());
        collector = std::make_unique<support::Process>(ANOGATE_MQTT, words);
        ASSERT_TRUE(collector->until_says("connected to the broker")) << collector->output();
    }
    bool until_collected(std::uint64_t first, std::uint64_t last) {
        return support::wait_until(
            [&] {
                const auto all = collected(dir / "all");
                for (std::uint64_t one = first; one <= last; ++one)
                    if (!all.contains(one)) return false;
                return true;
            },
            support::patience, [] { std::this_thread::sleep_for(100ms); });
    }

    std::unique_ptr<support::Process> collector;
};

TEST_F(MqttOutage, records_of_an_outage_reach_the_reader_once_as_lines_and_as_a_recording) {
    support::TempDir kept;
    Mosquitto mosquitto{persistent(kept.path().string())};    // the reader's session outlives the broker
    start_gateway();
    start_collector(mosquitto.address(), {"--mcap"});
    start_program(mosquitto.address());
    ASSERT_TRUE(until_connected());
    while (number < 100) send(++number);
    ASSERT_TRUE(until_collected(1, 100));
    mosquitto.kill();
    ASSERT_TRUE(program->until_says("connecting again"));
    for (int i = 0; i < 2500; ++i) {
        send(++number);
        if (number % 20 == 0) std::this_thread::sleep_for(10ms);
    }
    mosquitto.start();
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_TRUE(until_collected(1, number));
    std::cout << "the backlog of 2500 records came within "
              << std::chrono::duration<double>{std::chrono::steady_clock::now() - begin}.count() << " s\n";
    for (const auto& [one, count] : collected(dir / "all")) EXPECT_EQ(count, 1) << one;
    collector->signal(SIGTERM);
    EXPECT_EQ(collector->wait(), 0);
    EXPECT_NE(collector->output().find(" 0 invalid"), std::string::npos) << collector->output();
    bool has_recording = false;
    for (const auto& entry : std::filesystem::directory_iterator{dir / "all/g"})
        has_recording = has_recording || entry.path().extension() == ".mcap";
    EXPECT_TRUE(has_recording);
    collector.reset();
    start_collector(mosquitto.address());    // it knows what it has
    EXPECT_NE(stop_program().find(" 0 records in the spool, 0 dropped"), std::string::npos);
}

TEST_F(MqttOutage, kill_of_program_and_broker_at_any_moment_loses_no_record_that_was_a_second_old) {
    support::TempDir kept;
    Mosquitto mosquitto{persistent(kept.path().string())};
    start_gateway();
    start_collector(mosquitto.address());
    std::mt19937 random{7};
    std::set<std::uint64_t> expected;
    const int rounds = std::getenv("ANOGATE_MQTT_ROUNDS") ? std::atoi(std::getenv("ANOGATE_MQTT_ROUNDS")) : 6;
    start_program(mosquitto.address());
    bool is_broker_up = true;
    for (int round = 0; round < rounds; ++round) {
        ASSERT_TRUE(program->until_says("connected to the gateway"));
        std::vector<std::pair<std::uint64_t, std::chrono::steady_clock::time_point>> sent;
        const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds{1800 + random() % 800};
        while (std::chrono::steady_clock::now() < until) {
            sent.push_back({++number, std::chrono::steady_clock::now()});
            send(number);
            std::this_thread::sleep_for(5ms);
        }
        const bool kills_broker = round % 3 != 0 && is_broker_up, kills_program = round % 3 != 1;
        const auto killed_at = std::chrono::steady_clock::now();
        if (kills_broker) mosquitto.kill();
        if (kills_program) program->signal(SIGKILL), program->wait();
        for (const auto& [one, time] : sent)
            if (killed_at - time > 1500ms) expected.insert(one);    // a second, and what a busy machine takes
        if (kills_program) start_program(mosquitto.address());
        if (std::getenv("ANOGATE_MQTT_ROUNDS"))
            std::cout << "round " << round << ": " << sent.front().first << " to " << sent.back().first
                      << (kills_broker ? ", broker" : "") << (kills_program ? ", program" : "")
                      << (is_broker_up ? "" : ", while the broker is down") << '\n';
        if (kills_broker) is_broker_up = false;
        if (round % 3 == 2 || round + 1 == rounds)
            if (!std::exchange(is_broker_up, true)) mosquitto.start();
    }
    const bool is_complete = support::wait_until(
        [&] {
            const auto all = collected(dir / "all");
            return std::all_of(expected.begin(), expected.end(), [&](std::uint64_t one) { return all.contains(one); });
        },
        support::patience, [] { std::this_thread::sleep_for(200ms); });
    const auto all = collected(dir / "all");
    std::size_t lost = 0, twice = 0;
    for (const std::uint64_t one : expected) lost += all.contains(one) ? 0u : 1u;
    for (const auto& [one, count] : all) twice += count > 1 ? 1u : 0u;
    std::cout << rounds << " kills: " << number << " frames sent, " << all.size() << " at the reader, " << lost << " of "
              << expected.size() << " lost, " << twice << " twice\n";
    for (const std::uint64_t one : expected)
        if (!all.contains(one)) std::cout << one << " is lost\n";
    EXPECT_TRUE(is_complete) << program->output();
    EXPECT_EQ(lost, 0u);
    EXPECT_EQ(twice, 0u);
}

TEST_F(MqttProgram, checks_and_prints_its_configuration) {
    const auto run = [&](std::vector<std::string> words) {
        support::Process one{ANOGATE_MQTT, words};
        const int status = one.wait();
        return std::pair{status, one.output()};
    };
    const std::string good = dir.write("good.json", R"({"broker": "a:1", "name": "g"})"),
                      bad = dir.write("bad.json", R"({"brok": "a:1"})");
    EXPECT_EQ(run({"--check", "--config", good}).first, 0);
    EXPECT_EQ(run({"--check", "--config", bad}).first, 78);
    EXPECT_EQ(run({"--config", dir.write("empty.json", "{}")}).first, 78);
    EXPECT_NE(run({"--print-config", "--config", good, "--broker", "b:2"}).second.find("\"b:2\""), std::string::npos);
    EXPECT_NE(run({"--print-acl"}).second.find("pattern write anogate/v1/%u/up/+/+"), std::string::npos);
    EXPECT_EQ(run({"--to", "x", "--broker", "a:1"}).first, 78);
}

}    // namespace
}    // namespace program_tests
