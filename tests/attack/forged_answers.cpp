// Answers sent with the address of a device that is on another link, and writes sent with that of a host. tests/README.md has the
// figures.
#include <support/asked.hpp>
#include <support/fake_device.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_device.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <optional>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

namespace forged_answers_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using nlohmann::json;

/// Sends its frames every few milliseconds while it exists.
class Forger {
public:
    Forger(std::uint16_t port, std::vector<Bytes> frames, std::chrono::milliseconds pause = 3ms)
        : port_{port}, frames_{std::move(frames)}, pause_{pause} {
        thread_ = std::thread{[this] {
            while (!stops_) {
                for (const Bytes& one : frames_) peer_.send(port_, one);
                std::this_thread::sleep_for(pause_);
            }
        }};
    }
    ~Forger() {
        stops_ = true;
        thread_.join();
    }
    Forger(const Forger&) = delete;
    Forger& operator=(const Forger&) = delete;

private:
    std::uint16_t port_;
    std::vector<Bytes> frames_;
    std::chrono::milliseconds pause_;
    UdpPeer peer_;
    std::atomic<bool> stops_ = false;
    std::thread thread_;
};

/// The device is pinned to its link or not, and whether that link and the one of the strangers are of one group.
struct Routed {
    bool is_pinned = false;
    const char* keys = "";           // of the device's link
    const char* keys_beside = "";    // of the strangers' link
    const char* name = "";
    friend void PrintTo(const Routed& routed, std::ostream* out) { *out << routed.name; }
};
constexpr Routed pinned{true, "", "", "a_pinned_address"};
constexpr Routed learned{false, "", "", "a_learned_address"};
constexpr Routed pinned_in_a_group{true, ",group=air", ",group=air", "a_pinned_address_in_a_group"};
constexpr Routed learned_in_a_group{false, ",group=air", ",group=air", "a_learned_address_in_a_group"};
constexpr Routed pinned_with_others{true, ",group=air", ",group=air,trusted=127.0.0.9", "a_pinned_address_beside_trusted_peers"};
constexpr Routed learned_with_others{false, ",group=air", ",group=air,trusted=127.0.0.9",
                                     "a_learned_address_beside_trusted_peers"};
constexpr auto name_of = [](const testing::TestParamInfo<Routed>& routed) { return std::string{routed.param.name}; };

/// A flight controller at a serial port, whose address is pinned there or not. PAR_0 is 0.
class ForgedAnswers : public testing::TestWithParam<Routed> {
protected:
    void SetUp() override {
        device.fake.make_parameters(10);
        device.fake.commands = {{{1, 0, 2}, {}, "LAND", ""}};
        device.fake.instead = [this, answers = device.fake.instead](ano::FrameView asked) -> std::optional<std::vector<Bytes>> {
            if (ignores_writes && asked.id() == write[3]) return std::vector<Bytes>{};
            if (asked.id() == write[3] && logs_an_error.exchange(false)) return std::vector<Bytes>{red_line};
            return answers(asked);
        };
        device.start();
        std::vector<std::string> words{"serial:" + (dir / "fc") + ",baud=115200,name=fc" + GetParam().keys,
                                       std::string{"udp-listen:127.0.0.1:0,name=net"} + GetParam().keys_beside};
        if (GetParam().is_pinned) words.insert(words.end(), {"--route", "0xDC=fc"});
        daemon.emplace(ANOGATED, socket, words, std::vector<std::string>{"STATE_DIRECTORY=" + (dir / "state")});
        ASSERT_TRUE(daemon->until_answers());
        ASSERT_TRUE(wait_until([&] { return asked(socket, "GET", "/devices/0xDC/parameters").status == 200; }));
    }
    json conflict() const {
        const json all = daemon->status().at("conflicts");
        return all.size() == 1 ? all.at(0) : json{};
    }

    static inline const Bytes write = frame(0xFE, 0xDC, 0xE1, {0, 0, 5});
    static inline const Bytes red_line = frame(0xDC, 0xFF, 0xA0, {1, 'r', 'e', 'a', 'l'});
    std::atomic<bool> ignores_writes = false;
    std::atomic<bool> logs_an_error = false;    // instead of the next answer to a write
    TempDir dir;
    std::string socket = dir / "control.sock";
    VendorDevice device{dir / "fc"};
    std::optional<Daemon> daemon;
};

constexpr const char* as_lines = "application/x-ndjson";

TEST_P(ForgedAnswers, to_a_read_are_not_accepted_and_the_job_reports_them) {
    const Forger forger{daemon->port("net"), {frame(0xDC, 0xFE, 0xE1, {0, 0, 99})}};
    ASSERT_TRUE(daemon->until([&](const json&) { return !conflict().is_null(); }));
    for (int i = 0; i < 10; ++i) {
        const auto answer = asked(socket, "GET", "/devices/0xDC/parameters/PAR_0");
        ASSERT_EQ(answer.status, 200u) << answer.body;
        EXPECT_EQ(json::parse(answer.body).at("value"), 0) << answer.body;
    }
    EXPECT_TRUE(wait_until([&] {    // a job may be over before one arrives
        const std::string lines = asked(socket, "GET", "/devices/0xDC/parameters", {}, as_lines).body;
        return lines.find("answers with the address 0xDC were received on net (127.0.0.1:") != std::string::npos;
    }));
    EXPECT_GE(conflict().at("count"), 1);
    EXPECT_EQ(conflict().at("claimed_by").at("link"), "net");
}

// With the address of the device, and with that of a port, by which some devices acknowledge.
TEST_P(ForgedAnswers, to_a_write_are_not_accepted) {
    ignores_writes = true;
    const auto check = [](std::uint8_t source) {
        return frame(source, 0xFE, 0x00, {write[3], write[write.size() - 2], write.back()});
    };
    const Forger forger{daemon->port("net"), {check(0xDC), check(1), frame(0xDC, 0xFE, 0xE1, {0, 0, 5})}};
    const auto answer = asked(socket, "PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 5})");
    EXPECT_GE(answer.status, 400u) << answer.body;
    EXPECT_NE(answer.body.find("answers with the address 0xDC were received on net"), std::string::npos) << answer.body;
}

TEST_P(ForgedAnswers, with_another_device_info_are_not_accepted) {
    const Forger forger{daemon->port("net"), {frame(0xDC, 0xFF, 0xE3, {0xDC, 100, 0, 9, 9, 0, 0, 0x20, 3, 'b', 'a', 'd'})}};
    ASSERT_TRUE(daemon->until([&](const json&) { return !conflict().is_null(); }));
    EXPECT_EQ(asked(socket, "GET", "/devices/0xDC/parameters").status, 200u);
    EXPECT_EQ(asked(socket, "GET", "/devices").body.find("bad"), std::string::npos);
}

TEST_P(ForgedAnswers, raise_no_alarm) {
    const std::string body = R"({"limits": [{"field": "power.voltage", "side": "below", "red": 13.6}]})";
    ASSERT_EQ(asked(socket, "PUT", "/devices/0xDC/limits", body).status, 200u);
    const Forger forger{daemon->port("net"), {frame(0xDC, 0xFF, 0x0D, {0x28, 0x05, 0, 0})}};    // 13.2 V
    ASSERT_TRUE(wait_until([&] { return daemon->count("net", "frames_in") >= 100; }));
    EXPECT_EQ(asked(socket, "GET", "/alarms").body, "{\"alarms\":[]}\n");
}

TEST_P(ForgedAnswers, are_not_logged_as_lines_of_the_device_or_counted_as_errors) {
    const Bytes forged = frame(0xDC, 0xFE, 0xA0, {1, 'f', 'o', 'r', 'g', 'e', 'd'});
    const Forger forger{daemon->port("net"), {forged, frame(0xDC, 0xFF, 0x06, {0, 2, 0, 0, 0})}};
    ASSERT_TRUE(wait_until([&] { return daemon->count("net", "frames_in") >= 100; }));
    const json log = json::parse(asked(socket, "GET", "/devices/0xDC/log").body);
    EXPECT_EQ(log.at("red"), 0);
    EXPECT_EQ(log.at("lines"), json::array());
    EXPECT_EQ(asked(socket, "GET", "/devices").body.find("red_lines"), std::string::npos);
}

// With an address of its own the sender belongs to the network: its log lines can be read, and cause no alarm.
TEST_P(ForgedAnswers, from_other_addresses_displace_no_log_line_of_a_device_and_count_as_no_error) {
    logs_an_error = true;
    asked(socket, "PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 5})");
    ASSERT_TRUE(wait_until([&] { return json::parse(asked(socket, "GET", "/devices/0xDC/log").body).at("red") == 1; }));
    std::vector<Bytes> forged;
    for (unsigned a = 0x20; a < 0x60; ++a)
        for (int i = 0; i < 4; ++i)
            forged.push_back(frame(static_cast<std::uint8_t>(a), 0xFE, 0xA0, {1, 'f', 'o', 'r', 'g', 'e', 'd'}));
    const Forger forger{daemon->port("net"), std::move(forged)};
    ASSERT_TRUE(wait_until([&] { return daemon->count("net", "frames_in") >= 6000; }));
    const json devices = json::parse(asked(socket, "GET", "/devices").body).at("devices");
    for (const json& one : devices) EXPECT_EQ(one.value("red_lines", 0), one.at("address") == "0xDC" ? 1 : 0) << one;
    const json all = json::parse(asked(socket, "GET", "/devices/0xFF/log").body).at("lines");
    EXPECT_EQ(std::count_if(all.begin(), all.end(), [](const json& line) { return line.at("text") == "real"; }), 1);
    EXPECT_EQ(all.back().value("counts", true), false);
}

// The hints must not contradict the configuration.
TEST_P(ForgedAnswers, are_reported_with_hints_that_fit_the_configuration) {
    const Forger forger{daemon->port("net"), {frame(0xDC, 0xFF, 0x03, Bytes(7, 1))}};
    ASSERT_TRUE(daemon->until([&](const json&) { return !conflict().is_null(); }));
    EXPECT_EQ(conflict().at("home"), json{"fc"});
    EXPECT_EQ(conflict().at("pinned"), GetParam().is_pinned);
    ASSERT_TRUE(daemon->until_says("claimed by net ("));
    if (*GetParam().keys != '\0') {
        EXPECT_TRUE(daemon->until_says("add an address to `trusted` only if you know that it is your device's"));
        EXPECT_EQ(daemon->output().find("--route"), std::string::npos) << daemon->output();
    } else if (GetParam().is_pinned) {
        EXPECT_TRUE(daemon->until_says("0xDC is pinned to fc, and is claimed by net (127.0.0.1:"));
        EXPECT_EQ(daemon->output().find("--route"), std::string::npos) << daemon->output();
    } else {
        EXPECT_TRUE(daemon->until_says("pin it: --route 0xDC=LINK"));
    }
}

// Any sender that reaches a link can use the address of any host.
TEST_P(ForgedAnswers, and_writes_from_other_hosts_block_no_command_and_no_other_operation) {
    std::vector<Bytes> writes;
    for (const std::uint8_t host : {std::uint8_t{0xD2}, std::uint8_t{0x33}, std::uint8_t{0xFE}})
        for (const std::uint8_t to : {std::uint8_t{0xDC}, std::uint8_t{0xFF}}) writes.push_back(frame(host, to, 0xE1, {0, 0, 5}));
    const Forger forger{daemon->port("net"), writes, 100ms};
    ASSERT_TRUE(wait_until([&] { return daemon->count("net", "frames_in") >= 20; }));
    for (int i = 0; i < 5; ++i) {
        const auto land = asked(socket, "POST", "/devices/0xDC/commands/LAND", "{}");
        EXPECT_EQ(land.status, 200u) << land.body;
    }
    for (const auto& [path, body] :
         {std::pair{"actions", R"({"action": "save"})"}, std::pair{"actions", R"({"action": "restore_defaults"})"},
          std::pair{"calibration", R"({"what": "accelerometer"})"}}) {
        const auto done = asked(socket, "POST", std::string{"/devices/0xDC/"} + path, body);
        EXPECT_LT(done.status, 300u) << done.body;
    }
    const std::string jobs = asked(socket, "GET", "/jobs").body;
    EXPECT_NE(jobs.find("also writes to 0xDC"), std::string::npos) << "it is told: " << jobs;
}

// A group forwards only one copy of a frame. The answer that a stranger sends first must not be taken for the device's own.
TEST_P(ForgedAnswers, that_equal_the_next_one_of_the_device_do_not_replace_it) {
    const Bytes written = frame(0xFE, 0xDC, 0xE1, {0, 0, 7});
    const Bytes check = frame(0xDC, 0xFE, 0x00, {written[3], written[written.size() - 2], written.back()});
    const Forger forger{daemon->port("net"), {check, frame(0xDC, 0xFE, 0xE1, {0, 0, 7})}};
    ASSERT_TRUE(wait_until([&] { return daemon->count("net", "frames_in") >= 20; }));
    for (int i = 0; i < 3; ++i) {
        const auto answer = asked(socket, "PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 7})");
        ASSERT_EQ(answer.status, 200u) << answer.body;
    }
}

// Frames for a group are sent on the link that received last.
TEST_P(ForgedAnswers, and_other_frames_draw_no_command_away_from_the_device) {
    const Forger forger{daemon->port("net"), {frame(0xDC, 0xFF, 0x03, Bytes(7, 1)), frame(0x33, 0xFF, 0x03, Bytes(7, 1))}, 1ms};
    ASSERT_TRUE(wait_until([&] { return daemon->count("net", "frames_in") >= 20; }));
    for (int i = 0; i < 5; ++i) {
        const auto land = asked(socket, "POST", "/devices/0xDC/commands/LAND", "{}");
        EXPECT_EQ(land.status, 200u) << land.body;
    }
}

INSTANTIATE_TEST_SUITE_P(At, ForgedAnswers,
                         testing::Values(pinned, learned, pinned_in_a_group, learned_in_a_group, pinned_with_others,
                                         learned_with_others),
                         name_of);

// Actions that are permitted on the ground only, such as an upgrade, a calibration and the restore of defaults, need a device
// without conflict.
class ForgedClaims : public ForgedAnswers {};
TEST_P(ForgedClaims, of_a_pinned_address_block_nothing) {
    const Forger forger{daemon->port("net"), {frame(0xDC, 0xFF, 0x03, Bytes(7, 1)), frame(0xDC, 0xFF, 0x06, {0, 2, 0, 0, 0})}};
    ASSERT_TRUE(daemon->until([&](const json&) { return !conflict().is_null(); }));
    const auto answer = asked(socket, "POST", "/devices/0xDC/actions", R"({"action": "restore_defaults"})");
    EXPECT_EQ(answer.body.find("several devices"), std::string::npos) << answer.body;
    EXPECT_NE(answer.status, 409u) << answer.body;
    const auto written = asked(socket, "PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 5})");
    EXPECT_EQ(written.status, 200u) << written.body;
}
INSTANTIATE_TEST_SUITE_P(At, ForgedClaims, testing::Values(pinned, pinned_in_a_group, pinned_with_others), name_of);

/// A flight controller in the network. PAR_0 is 0.
class DeviceInTheNetwork {
public:
    explicit DeviceInTheNetwork(const std::string& local = "127.0.0.1:0") : peer_{local} {
        device_.make_parameters(10);
        device_.commands = {{{1, 0, 2}, {}, "LAND", ""}};
        device_.instead = [this](ano::FrameView asked) {
            return ignores_writes && asked.id() == 0xE1 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
        };
    }
    ~DeviceInTheNetwork() {
        stops_ = true;
        if (thread_.joinable()) thread_.join();
    }
    DeviceInTheNetwork(const DeviceInTheNetwork&) = delete;
    DeviceInTheNetwork& operator=(const DeviceInTheNetwork&) = delete;

    void start(std::uint16_t port) {
        thread_ = std::thread{[this, port] {
            for (int turn = 0; !stops_; ++turn) {
                if (turn % 50 == 0) peer_.send(gateway(port), frame(0xDC, 0xFF, 0x03, Bytes(7)));
                for (const Bytes& one : peer_.frames())
                    for (const Bytes& said : device_.take(ano::FrameView{one})) peer_.send(gateway(port), said);
                std::this_thread::sleep_for(2ms);
            }
        }};
    }

    std::atomic<bool> ignores_writes = false;

private:
    static anogate::Endpoint gateway(std::uint16_t port) { return {anogate::IpAddress::v4(127, 0, 0, 1), port}; }

    FakeDevice device_;
    UdpPeer peer_;
    std::atomic<bool> stops_ = false;
    std::thread thread_;
};

/// Its address is pinned to a link on which others may send as well, or not.
class ForgedBeside : public testing::TestWithParam<bool> {
protected:
    void SetUp() override {
        std::vector<std::string> words{"udp-listen:127.0.0.1:0,name=net"};
        if (GetParam()) words.insert(words.end(), {"--route", "0xDC=net"});
        daemon.emplace(ANOGATED, socket, words, std::vector<std::string>{"STATE_DIRECTORY=" + (dir / "state")});
        ASSERT_TRUE(daemon->until_answers());
        device.start(daemon->port("net"));
        ASSERT_TRUE(wait_until([&] { return asked(socket, "GET", "/devices/0xDC/parameters").status == 200; }));
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    DeviceInTheNetwork device;
    std::optional<Daemon> daemon;
};

TEST_P(ForgedBeside, answers_to_a_read_and_to_a_write_are_not_accepted) {
    const auto check = [](std::uint8_t source) {
        const Bytes write = frame(0xFE, 0xDC, 0xE1, {0, 0, 5});
        return frame(source, 0xFE, 0x00, {write[3], write[write.size() - 2], write.back()});
    };
    const Forger forger{daemon->port("net"), {frame(0xDC, 0xFE, 0xE1, {0, 0, 99}), check(0xDC), check(1)}};
    ASSERT_TRUE(daemon->until([](const json& status) { return status.at("conflicts").size() == 1; }));
    for (int i = 0; i < 10; ++i) {
        const auto answer = asked(socket, "GET", "/devices/0xDC/parameters/PAR_0");
        ASSERT_EQ(answer.status, 200u) << answer.body;
        EXPECT_EQ(json::parse(answer.body).at("value"), 0) << answer.body;
    }
    device.ignores_writes = true;
    const auto written = asked(socket, "PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 5})");
    EXPECT_GE(written.status, 400u) << written.body;
    EXPECT_NE(written.body.find("answers with the address 0xDC were received on net (127.0.0.1:"), std::string::npos)
        << written.body;
}

INSTANTIATE_TEST_SUITE_P(At, ForgedBeside, testing::Values(true, false),
                         [](const auto& is_pinned) { return is_pinned.param ? "a_pinned_address" : "a_learned_address"; });

/// A vehicle with two radios of one group, one at a serial port and one in the network, between which it changes.
class RadiosOfAGroup : public ForgedAnswers {};

TEST_P(RadiosOfAGroup, replace_each_other_while_a_stranger_sends) {
    const auto land_is_answered = [&] { return asked(socket, "POST", "/devices/0xDC/commands/LAND", "{}").status == 200; };
    DeviceInTheNetwork radio{"127.0.0.9:0"};
    const unsigned calls = device.calls();
    ASSERT_TRUE(wait_until(land_is_answered));
    EXPECT_GT(device.calls(), calls);
    device.mute(true);
    radio.start(daemon->port("net"));
    EXPECT_TRUE(wait_until(land_is_answered));
    {
        const Forger forger{daemon->port("net"), {frame(0xDC, 0xFE, 0xE1, {0, 0, 99})}};
        ASSERT_TRUE(daemon->until([&](const json&) { return !conflict().is_null(); }));
        for (int i = 0; i < 3; ++i) {
            const auto answer = asked(socket, "GET", "/devices/0xDC/parameters/PAR_0");
            ASSERT_EQ(answer.status, 200u) << answer.body;
            EXPECT_EQ(json::parse(answer.body).at("value"), 0) << answer.body;
            EXPECT_TRUE(land_is_answered());
        }
    }
    device.mute(false);
    EXPECT_TRUE(wait_until(land_is_answered));
}

INSTANTIATE_TEST_SUITE_P(At, RadiosOfAGroup, testing::Values(learned_in_a_group, pinned_with_others, learned_with_others),
                         name_of);

/// Pinned to a serial port, in a group with a link whose peers are not trusted.
class PinnedRadio : public ForgedAnswers {};

TEST_P(PinnedRadio, is_not_replaced_by_an_unknown_peer_while_it_is_silent) {
    DeviceInTheNetwork stranger{"127.0.0.9:0"};
    device.mute(true);
    stranger.start(daemon->port("net"));
    ASSERT_TRUE(daemon->until([&](const json&) { return !conflict().is_null(); }));
    const auto answer = asked(socket, "POST", "/devices/0xDC/commands/LAND", "{}");
    EXPECT_EQ(answer.status, 504u) << answer.body;
}

INSTANTIATE_TEST_SUITE_P(At, PinnedRadio, testing::Values(pinned_in_a_group), name_of);

/// A vehicle in the network, lost in flight, and another sender on another link or on the same one.
class LostVehicle : public testing::TestWithParam<const char*> {
protected:
    void SetUp() override {
        ASSERT_TRUE(daemon.until_answers());
        for (int i = 0; i < 3; ++i) send(vehicle, "air", 2);
        ASSERT_TRUE(daemon.until([&](const json&) { return lost().size() == 1; }));
    }
    void send(UdpPeer& from, const std::string& link, std::uint8_t state) {
        auto to = from.local();
        to.port = daemon.port(link);
        from.send(to, frame(0xDC, 0xFF, 0x06, {1, state, 0, 0, 0}));
    }
    /// Waits until the gateway has evaluated the frames that `who` sends.
    json lost_while_it_sends(UdpPeer& who, const std::string& link) {
        json all;
        daemon.until([&](const json&) {
            send(who, link, 1);
            all = lost();
            return all.empty() || all.at(0).contains("elsewhere");
        });
        return all;
    }
    json lost() { return json::parse(asked(socket, "GET", "/devices").body).value("lost", json::array()); }

    TempDir dir;
    std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED,
                  socket,
                  {"udp-listen:0.0.0.0:0,name=air", "udp-listen:0.0.0.0:0,name=ground"},
                  {"STATE_DIRECTORY=" + (dir / "state")}};
    UdpPeer vehicle{"127.0.0.2:0"}, stranger{"127.0.0.3:0"};
};

TEST_P(LostVehicle, stays_lost_while_a_stranger_sends_with_its_address) {
    const std::string where = std::string{GetParam()} + " (" + stranger.local().text() + ")";
    const json still = lost_while_it_sends(stranger, GetParam());
    ASSERT_EQ(still.size(), 1u);
    EXPECT_EQ(still.at(0).at("elsewhere"), where);
    EXPECT_EQ(still.at(0).at("sflag"), 2);
    EXPECT_TRUE(
        daemon.until_says("0xDC now sends on " + where +
                          ", but was last seen on air (127.0.0.2): this may be another device, so it stays lost. If it is "
                          "the same device: anoctl routes --forget 0xDC\n"))
        << daemon.output();
    send(vehicle, "air", 2);
    EXPECT_TRUE(daemon.until([&](const json&) { return lost().empty(); })) << "it is back";
}

TEST_P(LostVehicle, is_recognized_at_its_new_address_once_the_user_forgets_its_route) {
    ASSERT_EQ(lost_while_it_sends(stranger, GetParam()).size(), 1u);
    EXPECT_EQ(asked(socket, "DELETE", "/routes/0xDC").status, 200u);
    EXPECT_TRUE(lost_while_it_sends(stranger, GetParam()).empty());
    for (int i = 0; i < 3; ++i) send(stranger, GetParam(), 2);
    ASSERT_TRUE(daemon.until([&](const json&) { return lost().size() == 1; }));
    EXPECT_FALSE(lost().at(0).contains("elsewhere"));
}

TEST_P(LostVehicle, is_recognized_on_another_port_of_the_same_host) {
    UdpPeer again{"127.0.0.2:0"};
    EXPECT_TRUE(lost_while_it_sends(again, "air").empty()) << "its program has begun again";
}

// Commands are sent there, so its limits apply; values that would clear an alarm are ignored.
TEST_P(LostVehicle, alarms_are_raised_but_not_cleared_by_values_from_elsewhere) {
    const std::string body = R"({"limits": [{"field": "power.voltage", "side": "below", "red": 13.6}]})";
    ASSERT_EQ(asked(socket, "PUT", "/devices/0xDC/limits", body).status, 200u);
    ASSERT_EQ(lost_while_it_sends(stranger, GetParam()).size(), 1u);
    const auto alarms_while = [&](UdpPeer& who, const std::string& link, std::uint8_t low, std::size_t wanted) {
        return daemon.until([&](const json&) {
            auto to = who.local();
            to.port = daemon.port(link);
            who.send(to, frame(0xDC, 0xFF, 0x0D, {low, 0x05, 0, 0}));    // 12.8 V + low / 100
            return json::parse(asked(socket, "GET", "/alarms").body).at("alarms").size() == wanted;
        });
    };
    ASSERT_TRUE(alarms_while(stranger, GetParam(), 0x28, 1)) << "13.2 V";
    const auto received = daemon.count(GetParam(), "frames_in");
    ASSERT_TRUE(daemon.until([&](const json&) {
        alarms_while(stranger, GetParam(), 0xF0, 1);    // 15.2 V
        return daemon.count(GetParam(), "frames_in") >= received + 10;
    }));
    EXPECT_EQ(json::parse(asked(socket, "GET", "/alarms").body).at("alarms").size(), 1u);
    EXPECT_TRUE(alarms_while(vehicle, "air", 0xF0, 0)) << "it is back, and well";
}

INSTANTIATE_TEST_SUITE_P(At, LostVehicle, testing::Values("ground", "air"),
                         [](const auto& link) { return link.param == std::string{"air"} ? "its_own_link" : "another_link"; });

}    // namespace
}    // namespace forged_answers_tests
