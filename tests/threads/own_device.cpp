// The gateway as a device, from outside: a host that follows only the protocol text, our own host engine, and the state after a
// restart.
#include <ano/hex.hpp>

#include <support/asked.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

namespace own_device_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using nlohmann::json;

constexpr std::uint8_t host = 0xFE, self = 21;

/// A host of a listening UDP link, which stores the frames that it receives.
struct Host {
    explicit Host(std::uint16_t gateway) : port{gateway} {}

    void send(const Bytes& bytes) { ASSERT_TRUE(peer.send(port, bytes)); }
    bool receives(const Bytes& bytes) {
        return wait_until([&] {
            read();
            return std::find(heard.begin(), heard.end(), bytes) != heard.end();
        });
    }
    bool receives_text(std::uint8_t id, const std::string& words) {
        return wait_until([&] {
            read();
            return std::any_of(heard.begin(), heard.end(), [&](const Bytes& f) {
                return f[3] == id && std::string(f.begin() + 6, f.end() - 2).find(words) != std::string::npos;
            });
        });
    }
    std::size_t count(std::uint8_t id) {
        read();
        return static_cast<std::size_t>(std::count_if(heard.begin(), heard.end(), [id](const Bytes& f) { return f[3] == id; }));
    }
    /// Everything sent before was received: the gateway handles frames in order.
    void settle() {
        const std::size_t before = count(0xE3);
        send(frame(host, self, 0xE0, {0, 0, 0}));
        ASSERT_TRUE(wait_until([&] { return count(0xE3) > before; }));
    }
    void read() {
        for (Bytes& one : peer.frames()) heard.push_back(std::move(one));
    }

    std::uint16_t port;
    UdpPeer peer;
    std::vector<Bytes> heard;
};

Bytes act(std::uint8_t id, const Bytes& data) { return frame(host, self, id, data); }
Bytes acknowledges(const Bytes& question) {
    return frame(self, question[1], 0x00, {question[3], question[question.size() - 2], question.back()});
}

class OwnDevice : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(start()); }
    json usual() const {
        return {{"gateway", {{"id", self}, {"name", "vehicle"}}},
                {"links", {"udp-listen:127.0.0.1:0,name=ground,manage", "udp-listen:127.0.0.1:0,name=guest"}}};
    }
    bool start() { return start(usual()); }
    bool start(const json& config) {
        daemon.reset();
        dir.write("anogate.json", config.dump());
        daemon.emplace(ANOGATED, socket, std::vector<std::string>{"--config", dir / "anogate.json"},
                       std::vector<std::string>{"STATE_DIRECTORY=" + (dir / "state")});
        return daemon->until_answers();
    }
    Host by(const std::string& link) { return Host{daemon->port(link)}; }
    json device() const { return daemon->status().at("gateway").at("device"); }
    json parameter(const std::string& name) const {
        const json now = device();
        for (const json& one : now.at("parameters"))
            if (one.at("name") == name) return one;
        return {};
    }
    bool until_parameter(const std::string& name, const json& value, const std::string& from) {
        return wait_until([&] { return parameter(name).at("value") == value && parameter(name).at("from") == from; });
    }
    std::string kept() const {
        std::ifstream file{dir / "state/parameters.json"};
        return {std::istreambuf_iterator<char>{file}, {}};
    }
    json ask(const std::string& method, const std::string& target, const std::string& body = {}) const {
        return json::parse(asked(socket, method, target, body).body, nullptr, false);
    }

    TempDir dir;
    std::string socket = dir / "control";
    std::optional<Daemon> daemon;
};

TEST_F(OwnDevice, answers_a_host_that_uses_only_the_published_protocol) {
    Host guest = by("guest");
    guest.send(hex("AB FE FF E0 03 00 00 00 00 8B 3B"));
    EXPECT_TRUE(guest.receives(hex("AB 15 FE E3 10 00 15 64 00 64 00 00 00 20 03 76 65 68 69 63 6C 65 91 5E")));
    guest.send(frame(host, self, 0xE0, {1, 0, 0}));
    EXPECT_TRUE(guest.receives(frame(self, host, 0xE0, {1, 7, 0})));
    guest.send(frame(host, self, 0xC1, {0, 0, 0}));
    EXPECT_TRUE(guest.receives(frame(self, host, 0xC1, {0, 6, 0})));
    const json status = daemon->status();
    for (const json& route : status.at("routes"))
        EXPECT_TRUE(route.at("address") != "0x15" || route.at("via") == "own") << "its own word teaches nothing";
}

TEST_F(OwnDevice, is_changed_only_through_links_with_manage) {
    Host guest = by("guest"), ground = by("ground");
    const Bytes write = act(0xE1, {1, 0, 0x88, 0x13, 0, 0}), reload = act(0xC0, {1, 0, 1}), restore = act(0xE0, {0x10, 0xAA, 0});
    for (const Bytes& one : {write, reload, restore}) guest.send(one);
    EXPECT_TRUE(guest.receives_text(0xA0, "received on guest, which has no manage=yes"));
    guest.settle();
    EXPECT_EQ(guest.count(0x00), 0u);
    EXPECT_EQ(device().at("not_managed"), 3);
    EXPECT_EQ(parameter("FORGET_AFTER").at("value"), 30'000);
    for (const Bytes& one : {write, reload}) {
        ground.send(one);
        EXPECT_TRUE(ground.receives(acknowledges(one)));
    }
    EXPECT_TRUE(ground.receives_text(0xA0, "reload:"));
    EXPECT_TRUE(until_parameter("FORGET_AFTER", 5000, "parameter"));
    EXPECT_TRUE(daemon->until_says("gateway.forget_after: 30s -> 5s"));
}

TEST_F(OwnDevice, closes_other_links_but_not_the_link_of_the_request) {
    Host ground = by("ground");
    const Bytes own = act(0xE1, {3, 0, 0}), other = act(0xE1, {5, 0, 0}), open = act(0xE1, {5, 0, 1});
    ground.send(own);
    EXPECT_TRUE(ground.receives_text(0xA0, "it would close ground, the link of the request"));
    ground.send(other);
    EXPECT_TRUE(ground.receives(acknowledges(other)));
    EXPECT_EQ(ground.count(0x00), 1u);
    EXPECT_TRUE(daemon->until([](const json& status) {
        return status.at("links")[1].at("error_id") == "disabled" && status.at("links")[1].at("state") == "waiting";
    }));
    EXPECT_EQ(daemon->link("ground").at("state"), "up");
    ground.send(open);
    EXPECT_TRUE(daemon->until_up("guest"));
    Host guest = by("guest");
    guest.send(hex("AB FE FF E0 03 00 00 00 00 8B 3B"));
    EXPECT_TRUE(wait_until([&] { return guest.count(0xE3) == 1; }));
}

TEST_F(OwnDevice, restarts_a_link_once_for_many_simultaneous_requests_without_blocking) {
    Host ground = by("ground");
    constexpr std::uint8_t many = 200;
    Bytes last;
    for (std::uint8_t i = 0; i < many; ++i) ground.send(last = act(0xC0, {1, 0, 3, 1, i}));
    EXPECT_TRUE(ground.receives(acknowledges(last)));
    EXPECT_TRUE(ask("POST", "/reload?dry_run").dump().find("error") == std::string::npos);
    const std::string log = daemon->output();
    std::size_t restarts = 0;
    for (std::size_t at = 0; (at = log.find("guest changed: restarted", at)) != std::string::npos; ++at) ++restarts;
    EXPECT_GE(restarts, 1u);
    EXPECT_LT(restarts, many / 2);
}

TEST_F(OwnDevice, does_not_confirm_a_pending_configuration_by_a_reload) {
    json config = usual();
    config["links"].push_back("udp-listen:127.0.0.1:0,name=third");
    dir.write("anogate.json", config.dump());
    ASSERT_EQ(asked(socket, "POST", "/reload?confirm_within=60s", {}).status, 200u);
    Host ground = by("ground");
    ground.send(act(0xC0, {1, 0, 1}));
    EXPECT_TRUE(ground.receives_text(0xA0, "RELOAD: a reloaded configuration is still waiting for confirmation"));
    EXPECT_EQ(daemon->status().at("gateway").at("config").at("state"), "unconfirmed");
}

TEST_F(OwnDevice, starts_if_the_file_of_saved_values_is_a_pipe) {
    daemon.reset();
    std::filesystem::create_directories(dir / "state");
    ASSERT_EQ(::mkfifo((dir / "state/parameters.json").c_str(), 0600), 0);
    ASSERT_EQ(::mkfifo((dir / "state/parameters.json.new").c_str(), 0600), 0);
    ASSERT_TRUE(start());
    EXPECT_TRUE(daemon->until_says("parameters.json: is not a file; using the values of the configuration"));
    Host ground = by("ground");
    const Bytes save = act(0xE0, {0x10, 0xAB, 0});
    ground.send(save);
    EXPECT_TRUE(ground.receives(acknowledges(save))) << "in its place";
}

TEST_F(OwnDevice, keeps_saved_values_until_the_file_changes_them) {
    const Bytes write = act(0xE1, {1, 0, 0x88, 0x13, 0, 0}), save = act(0xE0, {0x10, 0xAB, 0});
    {
        Host ground = by("ground");
        ground.send(write);
        ground.send(save);
        EXPECT_TRUE(ground.receives(acknowledges(save)));
    }
    EXPECT_TRUE(std::filesystem::exists(dir / "state/parameters.json"));
    ASSERT_TRUE(start());
    EXPECT_TRUE(until_parameter("FORGET_AFTER", 5000, "parameter"));
    EXPECT_EQ(parameter("LOG_LEVEL"), (json{{"name", "LOG_LEVEL"}, {"key", "log/level"}, {"value", 2}, {"from", "default"}}));
    json config = usual();
    config["gateway"]["forget_after"] = "1m";
    dir.write("anogate.json", config.dump());
    daemon->signal(SIGHUP);
    EXPECT_TRUE(until_parameter("FORGET_AFTER", 60'000, "file"));
    EXPECT_TRUE(wait_until([&] { return kept().find("forget_after") == std::string::npos; }))
        << "or it would be back when the file says 30 s again";
    ASSERT_TRUE(start());
    EXPECT_TRUE(until_parameter("FORGET_AFTER", 30'000, "default"));
}

TEST_F(OwnDevice, removes_saved_values_that_the_file_overrides_even_if_just_saved) {
    const Bytes write = act(0xE1, {1, 0, 0x88, 0x13, 0, 0}), save = act(0xE0, {0x10, 0xAB, 0});
    Host ground = by("ground");
    ground.send(write);
    ground.send(save);
    ASSERT_TRUE(ground.receives(acknowledges(save)));
    ASSERT_NE(kept().find("forget_after"), std::string::npos);
    json config = usual();
    config["gateway"]["forget_after"] = "1m";
    dir.write("anogate.json", config.dump());
    daemon->signal(SIGHUP);
    EXPECT_TRUE(wait_until([&] { return kept().find("forget_after") == std::string::npos; }));
}

TEST_F(OwnDevice, loses_unsaved_values_at_a_restart) {
    {
        Host ground = by("ground");
        const Bytes write = act(0xE1, {1, 0, 0x88, 0x13, 0, 0});
        ground.send(write);
        EXPECT_TRUE(ground.receives(acknowledges(write)));
    }
    ASSERT_TRUE(start());
    EXPECT_EQ(parameter("FORGET_AFTER").at("from"), "default");
}

TEST_F(OwnDevice, reports_link_changes_and_a_summary_to_hosts) {
    PtyDevice fc{dir / "fc"};
    json config = usual();
    config["links"].push_back("serial:" + fc.path() + ",name=fc");
    ASSERT_TRUE(start(config));
    ASSERT_TRUE(daemon->until_up("fc"));
    Host ground = by("ground");
    ground.settle();
    fc.unplug();
    EXPECT_TRUE(ground.receives_text(0xA0,
                                     "\x01"
                                     "fc: "));
    fc.plug();
    EXPECT_TRUE(ground.receives_text(0xA0,
                                     "\x02"
                                     "fc: up"));
    const Bytes begin = act(0xC0, {1, 0, 4, 1}), restart = act(0xC0, {1, 0, 3, 2});
    ground.send(begin);
    EXPECT_TRUE(ground.receives(acknowledges(begin)));
    EXPECT_TRUE(wait_until([&] { return ground.count(0xF1) == 3; })) << "one of each link";
    ground.send(restart);
    EXPECT_TRUE(ground.receives(acknowledges(restart)));
    EXPECT_TRUE(daemon->until_says("fc changed: restarted"));
    EXPECT_TRUE(daemon->until_up("fc"));
}

TEST_F(OwnDevice, works_as_a_device_with_the_built_in_host_engine) {
    const json listed = ask("GET", "/devices/21/parameters");
    ASSERT_EQ(listed.at("parameters").size(), 7u) << listed;
    const json written = ask("PUT", "/devices/vehicle/parameters/FORGET_AFTER", R"({"value": 500})");
    EXPECT_EQ(written.at("stored"), 1000) << written;
    EXPECT_EQ(written.at("clamped"), true) << written;
    EXPECT_EQ(ask("POST", "/devices/21/commands/RESTART_LINK", R"({"values": [0]})").dump().find("error"), std::string::npos);
    EXPECT_TRUE(daemon->until_says("ground changed: restarted"));
    const json refused = ask("POST", "/devices/21/commands/RESTART_LINK", R"({"values": [77]})");
    EXPECT_EQ(refused.at("what"), "refused") << refused;
    EXPECT_EQ(refused.at("error"), "RESTART_LINK: there is no link 77") << refused;
    EXPECT_EQ(ask("POST", "/devices/21/actions", R"({"action": "save"})").dump().find("error"), std::string::npos);
    EXPECT_TRUE(std::filesystem::exists(dir / "state/parameters.json"));
    EXPECT_EQ(ask("GET", "/devices").at("devices")[0].at("name"), "vehicle");
}

TEST_F(OwnDevice, is_not_changed_through_the_control_interface_without_manage) {
    json config = usual();
    config["control"]["manage"] = false;
    ASSERT_TRUE(start(config));
    EXPECT_EQ(ask("GET", "/devices/21/parameters").at("parameters").size(), 7u);
    const auto is_refused = [&](const char* method, const char* target, const char* body) {
        const json told = ask(method, target, body);
        EXPECT_EQ(told.at("error"), "the control interface is not allowed to manage the gateway (control.manage)") << target;
        EXPECT_EQ(told.at("what"), "refused") << target;
    };
    is_refused("PUT", "/devices/21/parameters/FORGET_AFTER", R"({"value": 5000})");
    is_refused("POST", "/devices/21/commands/RESTART_LINK", R"({"values": [0]})");
    is_refused("POST", "/devices/21/actions", R"({"action": "save"})");
    const Bytes write = act(0xE1, {1, 0, 0x88, 0x13, 0, 0});
    const json sent = ask("POST", "/send", json{{"hex", ano::hex(write)}}.dump());
    EXPECT_EQ(sent.at("taken_by"), "gateway") << sent;
    EXPECT_EQ(device().at("not_managed"), 1);
    EXPECT_EQ(parameter("FORGET_AFTER").at("value"), 30'000);
}

// A broadcast question is forwarded, each device answers it once, and no answer is treated as another question.
TEST_F(OwnDevice, and_another_one_do_not_exchange_frames_endlessly) {
    TempDir there;
    json others = {{"gateway", {{"id", 22}}},
                   {"links", {"udp:127.0.0.1:" + std::to_string(daemon->port("ground")) + ",name=there,manage"}}};
    there.write("anogate.json", others.dump());
    Daemon other{ANOGATED, there / "control", {"--config", there / "anogate.json"}, {"STATE_DIRECTORY=" + (there / "state")}};
    ASSERT_TRUE(other.until_up("there"));
    ASSERT_EQ(asked(there / "control", "POST", "/send", R"({"hex": "ABFE15E003000000 00"})").status, 400u) << "no check bytes";
    asked(there / "control", "POST", "/devices/scan", {});
    Host ground = by("ground");
    ground.send(hex("AB FE FF E0 03 00 00 00 00 8B 3B"));
    EXPECT_TRUE(wait_until([&] { return ground.count(0xE3) == 2; })) << "one of each gateway";
    for (const Bytes& data : std::vector<Bytes>{{1, 0, 0}, {2, 1, 0}, {3, 1, 0}}) ground.send(frame(22, self, 0xE0, data));
    ground.settle();
    const auto passed = [&] { return other.count("there", "frames_in") + other.count("there", "frames_out"); };
    std::uint64_t before = 0;
    EXPECT_TRUE(wait_until([&] { return std::exchange(before, passed()) == passed(); }, 5s,
                           [] { std::this_thread::sleep_for(std::chrono::milliseconds{200}); }))
        << "it does not end";
    EXPECT_LE(other.status().at("gateway").at("device").at("answered"), 7)
        << "its own scan asks three times, the host once, and the other gateway up to three times who 22 is";
}

}    // namespace
}    // namespace own_device_tests
