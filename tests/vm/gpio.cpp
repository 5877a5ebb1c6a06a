// GPIO lines on the kernel's simulated chips, observed from their other side. Needs the machine of tests/vm/machine, or root on a
// kernel that has gpio-sim.
#include "gpio_sim.hpp"

#include <config/config.hpp>
#include <gateway/backoff.hpp>
#include <gpio/gpio_control.hpp>
#include <link/kinds.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/wait.hpp>

#include <gtest/gtest.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>

#include <fcntl.h>
#include <termios.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace gpio_tests {

using namespace std::chrono_literals;
using anogate::Clock;
using nlohmann::json;
using support::Bytes;
using support::frame;
using support::GpioSim;
using support::Loop;
using support::UdpPeer;

namespace {

bool in_vm() { return std::getenv("ANOGATE_IN_VM") != nullptr; }

// A gateway from a configuration as a user writes it.
class GpioGateway : public support::RunningGateway {
public:
    GpioGateway(Loop& loop, const std::string& links, const std::string& gpio, const std::string& more = {})
        : RunningGateway{loop, settings("{\"links\": [" + links + "], \"gpio\": [" + gpio + "]" + more + "}")} {}
    json gpio(std::size_t i = 0) { return status().at("gpio").at(i); }
    anogate::http::Response post(const std::string& body) {
        return anogate::gpio_request(gateway().gpio(), body, gateway().now());
    }

private:
    static anogate::Settings settings(const std::string& config) {
        const anogate::Draft draft = anogate::parse_config(config, anogate::link_kinds());
        if (!draft.errors.empty()) throw std::runtime_error(anogate::lines(draft.errors));
        return draft.settings;
    }
};

struct Gpio : testing::Test {
    void SetUp() override {
        if (std::filesystem::exists("/sys/kernel/config/gpio-sim") && ::geteuid() == 0) return;
        if (in_vm()) FAIL() << "no gpio-sim in the test machine";
        GTEST_SKIP() << "this kernel has no gpio-sim, or we may not use it; tests/vm/run runs it in a machine that has";
    }
    static std::string line(const GpioSim& sim, int number, const std::string& rest) {
        return "{\"chip\": \"" + sim.chip() + "\", \"line\": " + std::to_string(number) + ", " + rest + "}";
    }
    static std::string udp(const std::string& name) {
        return "{\"kind\": \"udp-listen\", \"address\": \"127.0.0.1:0\", \"name\": \"" + name + "\"}";
    }
    bool becomes(const GpioSim& sim, int number, bool level) {
        return loop.until([&] { return sim.level(number) == level; });
    }
    std::size_t received(UdpPeer& from, std::size_t count, std::chrono::seconds patience = 30s) {
        std::size_t n = 0;
        loop.until([&] { return (n += from.frames().size()) >= count; }, patience);
        return n;
    }
    Loop loop;
    support::TempDir dir;
};

const Bytes attitude = frame(0xFE, 0xDC, 0x03, Bytes(7));
const Bytes command = frame(0xFE, 0xDC, 0xC0, {1, 2, 3});

TEST_F(Gpio, link_up_is_on_while_the_link_is_up) {
    GpioSim sim{"a", 4};
    const std::string links = "{\"kind\": \"serial\", \"device\": \"" + (dir / "port") + "\", \"name\": \"fc\"}";
    GpioGateway gateway{loop, links,
                        line(sim, 0, R"("use": "link_up", "link": "fc")") + "," +
                            line(sim, 1, R"("use": "link_up", "link": "fc", "active_low": true)")};
    EXPECT_FALSE(sim.level(0));
    EXPECT_TRUE(sim.level(1)) << "active low: off is high";
    EXPECT_EQ(gateway.gpio()["value"], false);
    support::PtyDevice device{dir / "port"};
    EXPECT_TRUE(becomes(sim, 0, true));
    EXPECT_FALSE(sim.level(1));
    EXPECT_EQ(gateway.gpio()["value"], true);
    EXPECT_EQ(gateway.gpio(1)["value"], true);
    device.unplug();
    EXPECT_TRUE(becomes(sim, 0, false));
    EXPECT_TRUE(sim.level(1));
    device.plug();
    EXPECT_TRUE(becomes(sim, 0, true));
    gateway.stop();
    EXPECT_FALSE(sim.level(0)) << "no gateway, no link";
}

TEST_F(Gpio, activity_blinks_with_the_traffic_and_never_faster_than_is_visible) {
    GpioSim sim{"a", 2};
    GpioGateway gateway{loop, udp("ground") + "," + udp("other"), line(sim, 0, R"("use": "activity", "link": "ground")")};
    UdpPeer app, other;
    EXPECT_FALSE(sim.level(0));
    other.send(gateway.port("other"), attitude);
    loop.until([&] { return gateway.link("other")["frames_in"] == 1; });
    EXPECT_EQ(gateway.gpio()["edges"], 0) << "of another link";
    app.send(gateway.port("ground"), attitude);
    EXPECT_TRUE(becomes(sim, 0, true)) << "one frame is a blink";
    EXPECT_TRUE(becomes(sim, 0, false));
    int blinks = 0;
    bool lit = false;
    const std::uint16_t to = gateway.port("ground");
    const std::uint64_t before = gateway.gpio()["edges"];
    const auto start = Clock::now();
    while (Clock::now() - start < 3s) {
        app.send(to, attitude);
        loop.turn();
        if (const bool now = sim.level(0); now != lit) blinks += (lit = now) ? 1 : 0;
    }
    const double took = std::chrono::duration<double>(Clock::now() - start).count();
    EXPECT_GE(blinks, 20) << "in " << took << " s";
    EXPECT_LE(blinks, 20 * took + 1);
    EXPECT_LE(static_cast<double>(gateway.gpio()["edges"].get<std::uint64_t>() - before), 40 * took + 2);
    EXPECT_TRUE(becomes(sim, 0, false));
    const std::uint64_t sent = gateway.gpio()["edges"];
    other.send(gateway.port("other"), frame(0xDC, 0xFF, 0x03, Bytes(7)));
    EXPECT_TRUE(loop.until([&] { return gateway.gpio()["edges"] > sent; }))
        << "what leaves by the link is traffic too" << gateway.status();
}

TEST_F(Gpio, power_is_on_from_the_start_and_cycled_on_request) {
    GpioSim sim{"a", 2};
    GpioGateway gateway{loop, udp("radio"), line(sim, 0, R"("use": "power", "link": "radio", "pulse": "300ms")")};
    EXPECT_TRUE(sim.level(0)) << "before anything else";
    const auto asked = Clock::now();
    const auto reply = gateway.post(R"({"line": 0, "use": "power"})");
    EXPECT_EQ(reply.status, 200u) << reply.body;
    EXPECT_EQ(json::parse(reply.body)["value"], false);
    EXPECT_FALSE(sim.level(0));
    EXPECT_EQ(gateway.post(R"({"line": 0})").status, 429u) << "it is off already";
    EXPECT_TRUE(becomes(sim, 0, true));
    EXPECT_GE(Clock::now() - asked, 300ms);
    EXPECT_EQ(gateway.gpio()["pulses"], 1);
    EXPECT_EQ(gateway.post(R"({"link": "radio", "action": "cycle"})").status, 200u) << "as often as it is asked for";
    EXPECT_FALSE(sim.level(0));
    EXPECT_TRUE(becomes(sim, 0, true));
}

TEST_F(Gpio, reset_is_pulsed_on_request_once_a_minute) {
    GpioSim sim{"a", 2};
    GpioGateway gateway{loop, udp("fc"), line(sim, 0, R"("use": "reset", "link": "fc", "active_low": true, "pulse": "200ms")")};
    EXPECT_TRUE(sim.level(0)) << "off is high";
    const auto asked = Clock::now();
    const auto reply = gateway.post(R"({"link": "fc", "use": "reset"})");
    EXPECT_EQ(reply.status, 200u) << reply.body;
    EXPECT_FALSE(sim.level(0));
    EXPECT_TRUE(becomes(sim, 0, true));
    EXPECT_GE(Clock::now() - asked, 200ms);
    const auto again = gateway.post(R"({"link": "fc", "use": "reset"})");
    EXPECT_EQ(again.status, 429u) << again.body;
    EXPECT_GT(json::parse(again.body)["wait_s"], 30);
    EXPECT_TRUE(sim.level(0));
    EXPECT_EQ(gateway.gpio()["pulses"], 1);
}

TEST_F(Gpio, reset_is_pulsed_when_the_link_is_silent_and_not_while_frames_are_received) {
    GpioSim sim{"a", 2};
    GpioGateway gateway{loop, udp("fc"), line(sim, 0, R"("use": "reset", "link": "fc", "pulse": "100ms", "when": "silent 2s")")};
    UdpPeer device;
    const std::uint16_t to = gateway.port("fc");
    const auto start = Clock::now();
    while (Clock::now() - start < 4s) {    // longer than the maximum silence
        device.send(to, attitude);
        loop.until([end = Clock::now() + 100ms] { return Clock::now() > end; });
        ASSERT_FALSE(sim.level(0));
    }
    const auto silent = Clock::now();
    EXPECT_TRUE(becomes(sim, 0, true));
    EXPECT_GE(Clock::now() - silent, 1800ms);
    EXPECT_TRUE(becomes(sim, 0, false));
    loop.until([end = Clock::now() + 5s] { return Clock::now() > end; });    // what must not happen
    EXPECT_EQ(gateway.gpio()["pulses"], 1) << "once a minute";
    EXPECT_EQ(gateway.gpio()["edges"], 2);
}

TEST_F(Gpio, inhibit_drops_control_frames_and_passes_the_rest) {
    GpioSim sim{"a", 4};
    sim.pull(2, true);
    GpioGateway gateway{loop, udp("ground") + "," + udp("fc") + "," + udp("desk"),
                        line(sim, 2, R"("use": "inhibit", "links": ["ground"])")};
    UdpPeer ground, fc, desk;
    fc.send(gateway.port("fc"), frame(0xDC, 0xFF, 0x03, Bytes(7)));
    EXPECT_EQ(gateway.gpio()["inhibiting"], true) << "the level at the start counts";
    EXPECT_EQ(gateway.gpio()["edges"], 0);
    loop.until([&] { return gateway.link("fc")["frames_in"] == 1; });
    const std::uint16_t to = gateway.port("ground");
    ground.send(to, command);
    ground.send(to, attitude);
    EXPECT_EQ(received(fc, 1), 1u) << "telemetry passes";
    EXPECT_EQ(gateway.link("ground")["inhibited"], 1);
    EXPECT_EQ(gateway.link("ground")["channels"][0]["inhibited"], 1);
    desk.send(gateway.port("desk"), command);
    EXPECT_EQ(received(fc, 1), 1u) << "another link is not meant";
    sim.pull(2, false);
    EXPECT_TRUE(loop.until([&] { return gateway.gpio()["inhibiting"] == false; }));
    EXPECT_EQ(gateway.gpio()["edges"], 1);
    ground.send(to, command);
    EXPECT_EQ(received(fc, 1), 1u);
    sim.pull(2, true);
    EXPECT_TRUE(loop.until([&] { return gateway.gpio()["inhibiting"] == true; }));
    ground.send(to, command);
    EXPECT_TRUE(loop.until([&] { return gateway.link("ground")["inhibited"] == 2; }));
    EXPECT_EQ(fc.frames().size(), 0u);
}

TEST_F(Gpio, inhibit_can_be_active_low_with_a_pull_up) {
    GpioSim sim{"a", 4};
    GpioGateway gateway{loop, udp("ground"),
                        line(sim, 1, R"("use": "inhibit", "links": ["ground"], "bias": "pull_up", "active_low": true)")};
    EXPECT_TRUE(sim.pulled_up(1)) << "the chip's own resistor";
    EXPECT_EQ(gateway.gpio()["inhibiting"], false) << "an open switch";
    sim.pull(1, false);
    EXPECT_TRUE(loop.until([&] { return gateway.gpio()["inhibiting"] == true; }));
}

TEST_F(Gpio, a_chattering_switch_does_not_fill_the_log) {
    GpioSim sim{"a", 2};
    const auto lines = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(1000);
    const auto usual = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", lines));
    spdlog::set_level(spdlog::level::warn);
    {
        GpioGateway gateway{loop, udp("ground"), line(sim, 0, R"("use": "inhibit", "links": ["ground"])")};
        const std::size_t before = lines->last_formatted().size();
        const auto began = std::chrono::steady_clock::now();
        for (int i = 1; i <= 101; ++i) {
            sim.pull(0, i % 2 == 1);
            ASSERT_TRUE(loop.until([&] { return gateway.gpio()["edges"] == i; }));
        }
        const std::size_t while_it_chatters = lines->last_formatted().size() - before;
        const auto took = std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - began);
        EXPECT_LE(while_it_chatters, 2u + static_cast<std::size_t>(took.count()));    // one at once, then one a second
        EXPECT_TRUE(loop.until([&] {
            const std::string last = lines->last_formatted(1).at(0);
            return last.find("on, control frames are dropped") != last.npos && last.find("changed") != last.npos;
        })) << lines->last_formatted(1).at(0);
    }
    spdlog::set_default_logger(usual);
    spdlog::set_level(spdlog::level::off);
}

TEST_F(Gpio, inhibit_cannot_be_bypassed_inside_a_tunnel_frame) {
    GpioSim sim{"a", 4};
    sim.pull(0, true);
    GpioGateway gateway{loop, udp("ground") + "," + udp("fc"), line(sim, 0, R"("use": "inhibit", "links": ["ground", "tunnel"])"),
                        R"(, "tunnel": {"links": [], "bind": "127.0.0.1", "port": 0, "allow": ["127.0.0.1/32"]})"};
    UdpPeer ground, fc, radio;
    fc.send(gateway.port("fc"), frame(0xDC, 0xFF, 0x03, Bytes(7)));
    loop.until([&] { return gateway.link("fc")["frames_in"] == 1; });
    const auto wrapped = [](const Bytes& inner) {
        Bytes data{0, 0, 0, 0, 127, 0, 0, 1, 0, 0};
        data.insert(data.end(), inner.begin(), inner.end());
        return frame(0xFE, 0xDC, 0xB1, data);
    };
    Bytes both = command;
    both.insert(both.end(), attitude.begin(), attitude.end());
    ground.send(gateway.port("ground"), wrapped(command));    // to the device, which would unwrap it
    ground.send(gateway.port("ground"), wrapped(attitude));
    EXPECT_EQ(received(fc, 1), 1u);
    EXPECT_EQ(gateway.link("ground")["inhibited"], 1);
    radio.send(gateway.port("tunnel"), wrapped(both));    // unwrapped here, frame by frame
    EXPECT_EQ(received(fc, 1), 1u) << "the attitude beside the command";
    EXPECT_EQ(gateway.link("tunnel")["inhibited"], 1);
    radio.send(gateway.port("tunnel"), wrapped(wrapped(command)));
    EXPECT_TRUE(loop.until([&] { return gateway.link("tunnel")["inhibited"] == 2; }));
    EXPECT_EQ(fc.frames().size(), 0u);
    sim.pull(0, false);
    EXPECT_TRUE(loop.until([&] { return gateway.gpio()["inhibiting"] == false; }));
    ground.send(gateway.port("ground"), wrapped(command));
    radio.send(gateway.port("tunnel"), wrapped(both));
    EXPECT_EQ(received(fc, 3), 3u);
}

TEST_F(Gpio, inhibit_counts_as_active_while_its_chip_is_missing) {
    GpioSim sim{"a", 4};
    sim.pull(0, false);
    const std::string chip = sim.chip();
    GpioGateway gateway{loop, udp("ground") + "," + udp("fc"),
                        "{\"chip\": \"" + sim.label() + R"(", "line": 0, "use": "inhibit", "links": ["ground"]})"};
    UdpPeer ground, fc;
    fc.send(gateway.port("fc"), frame(0xDC, 0xFF, 0x03, Bytes(7)));
    loop.until([&] { return gateway.link("fc")["frames_in"] == 1; });
    ground.send(gateway.port("ground"), command);
    EXPECT_EQ(received(fc, 1), 1u);
    for (int turn = 0; turn < 3; ++turn) {
        sim.unplug();
        EXPECT_TRUE(loop.until([&] { return gateway.gpio()["state"] == "waiting"; }))
            << "nobody asks the line: the chip's going tells";
        EXPECT_EQ(gateway.gpio()["inhibiting"], true);
        EXPECT_EQ(gateway.gpio()["value"], nullptr);
        EXPECT_EQ(gateway.gpio()["chip"], sim.label());
        const std::uint64_t before = gateway.link("ground")["inhibited"];
        ground.send(gateway.port("ground"), command);
        EXPECT_TRUE(loop.until([&] { return gateway.link("ground")["inhibited"] == before + 1; }));
        EXPECT_EQ(fc.frames().size(), 0u);
        sim.plug();
        EXPECT_TRUE(loop.until([&] { return gateway.gpio()["state"] == "held"; }));
        EXPECT_EQ(gateway.gpio()["inhibiting"], false);
        ground.send(gateway.port("ground"), command);
        EXPECT_EQ(received(fc, 1), 1u);
        sim.pull(0, true);
        EXPECT_TRUE(loop.until([&] { return gateway.gpio()["inhibiting"] == true; })) << "its edges are heard again";
        sim.pull(0, false);
        EXPECT_TRUE(loop.until([&] { return gateway.gpio()["inhibiting"] == false; }));
    }
}

TEST_F(Gpio, no_final_state_is_missed_in_ten_thousand_edges) {
    GpioSim sim{"a", 2};
    GpioGateway gateway{loop, udp("ground"), line(sim, 0, R"("use": "inhibit", "links": ["ground"])")};
    const int file = ::open(sim.pull_file(0).c_str(), O_WRONLY);
    ASSERT_GE(file, 0);
    const auto put = [&](bool up) { return ::pwrite(file, up ? "pull-up" : "pull-down", up ? 7 : 9, 0) > 0; };
    int failed = 0;
    for (int burst = 0; burst < 100; ++burst) {
        const int edges = 100 + burst % 2;    // every other burst ends high
        std::atomic<bool> done{false};
        std::thread hand{[&] {    // while the gateway reads, and faster than it does: the kernel stores 16 edges
            for (int i = 0; i < edges; ++i)
                if (!put((i + edges) % 2 == 1)) ++failed;
            done = true;
        }};
        ASSERT_TRUE(loop.until([&] { return done.load(); }));
        hand.join();
        const bool high = sim.pulled_up(0);
        ASSERT_TRUE(loop.until([&] { return gateway.gpio()["inhibiting"] == high; }, 5s)) << "burst " << burst;
        loop.turn();
        ASSERT_EQ(gateway.gpio()["inhibiting"], high) << "burst " << burst;
    }
    ::close(file);
    EXPECT_EQ(failed, 0);
    EXPECT_GE(gateway.gpio()["edges"], 100);
}

TEST_F(Gpio, edges_that_occur_one_by_one_are_all_counted) {
    const auto begin = Clock::now();
    GpioSim sim{"a", 2};
    GpioGateway gateway{loop, udp("ground"), line(sim, 0, R"("use": "inhibit", "links": ["ground"])")};
    for (int i = 1; i <= 200; ++i) {
        sim.pull(0, i % 2 == 1);
        ASSERT_TRUE(loop.until([&] { return gateway.gpio()["edges"] == i; })) << i << gateway.gpio();
        ASSERT_EQ(gateway.gpio()["inhibiting"], i % 2 == 1);
    }
    const double age = gateway.gpio()["edge_s"];
    EXPECT_LE(age, std::chrono::duration<double>(Clock::now() - begin).count());
}

TEST_F(Gpio, a_line_is_found_by_name_on_any_chip_and_a_chip_by_path_or_label) {
    GpioSim first{"a", 2}, second{"b", 4, {{3, "ACT_LED"}}};
    GpioGateway gateway{loop, udp("ground"),
                        R"({"line": "ACT_LED", "use": "link_up", "link": "ground"},
                           {"chip": "/dev/)" +
                            first.chip() + R"(", "line": 0, "use": "link_up", "link": "ground"},
                           {"chip": ")" +
                            second.label() + R"(", "line": 1, "use": "link_up", "link": "ground"})"};
    EXPECT_TRUE(second.level(3));
    EXPECT_TRUE(first.level(0));
    EXPECT_TRUE(second.level(1));
    EXPECT_EQ(gateway.gpio()["chip"], second.chip());
    EXPECT_EQ(gateway.gpio()["line"], 3);
    EXPECT_EQ(gateway.gpio()["name"], "ACT_LED");
    EXPECT_EQ(gateway.gpio(2)["chip"], second.chip());
}

TEST_F(Gpio, an_unavailable_line_is_reported_and_waited_for) {
    GpioSim sim{"a", 4, {{1, "LAMP"}}, {{1, "the-kernel"}}};
    auto later = std::make_unique<GpioSim>("b", 1);
    const std::string absent = later->chip();
    later.reset();
    GpioGateway gateway{loop, udp("ground"),
                        line(sim, 1, R"("use": "link_up", "link": "ground")") + "," +
                            line(sim, 9, R"("use": "link_up", "link": "ground")") +
                            R"(,{"chip": "sim-b", "line": 0, "use": "power"}, {"line": "NOBODYS", "use": "power"})"};
    EXPECT_EQ(gateway.gpio(0)["error"], sim.chip() + " line 1 (LAMP) is in use by the-kernel");
    EXPECT_EQ(gateway.gpio(1)["error"], sim.chip() + " has lines 0 to 3, not 9");
    EXPECT_EQ(gateway.gpio(2)["error"], "sim-b line 0: the chip was not found");
    EXPECT_EQ(gateway.gpio(3)["error"], "no GPIO chip has a line NOBODYS");
    const auto reply = gateway.post(R"({"line": "NOBODYS"})");
    EXPECT_EQ(reply.status, 409u);
    EXPECT_NE(reply.body.find("no GPIO chip has a line NOBODYS"), std::string::npos);
    EXPECT_EQ(gateway.link("ground")["state"], "up") << "the rest runs";
    GpioSim there{"b", 2, {{1, "NOBODYS"}}};
    EXPECT_TRUE(loop.until([&] { return gateway.gpio(2)["state"] == "held" && gateway.gpio(3)["state"] == "held"; }));
    EXPECT_TRUE(there.level(0) && there.level(1));
}

TEST_F(Gpio, a_line_is_used_exclusively_and_released_at_the_end) {
    GpioSim sim{"a", 2};
    auto first = std::make_unique<GpioGateway>(loop, udp("ground"), line(sim, 0, R"("use": "link_up", "link": "ground")"));
    GpioGateway second{loop, udp("ground"), line(sim, 0, R"("use": "link_up", "link": "ground")")};
    EXPECT_EQ(second.gpio()["error"], sim.chip() + " line 0 is in use by anogate link_up");
    first.reset();
    EXPECT_TRUE(loop.until([&] { return second.gpio()["state"] == "held"; }));
    EXPECT_TRUE(sim.level(0)) << "as it should be by then";
}

TEST_F(Gpio, a_missing_permission_is_reported_and_waited_for) {
    GpioSim sim{"a", 2, {{0, "LAMP"}}};
    const std::string node = "/dev/" + sim.chip();
    std::filesystem::permissions(node, std::filesystem::perms::owner_all);
    ASSERT_EQ(::seteuid(65534), 0);
    {
        GpioGateway gateway{loop, udp("ground"), line(sim, 1, R"("use": "power")") + R"(,{"line": "LAMP", "use": "power"})"};
        const std::string why = "permission denied for " + node + " (the user must be in the group of the device, usually gpio)";
        EXPECT_EQ(gateway.gpio(0)["error"], sim.chip() + " line 1: " + why);
        EXPECT_EQ(gateway.gpio(1)["error"], "line LAMP: " + why);
        ASSERT_EQ(::seteuid(0), 0);
        std::filesystem::permissions(node, std::filesystem::perms::all);
        ASSERT_EQ(::seteuid(65534), 0);
        EXPECT_TRUE(loop.until([&] { return gateway.gpio(0)["state"] == "held" && gateway.gpio(1)["state"] == "held"; }));
    }
    ASSERT_EQ(::seteuid(0), 0);
}

TEST_F(Gpio, outputs_are_restored_when_the_chip_returns) {
    GpioSim sim{"a", 4};
    const std::string chip = "{\"chip\": \"" + sim.label() + "\", ";
    GpioGateway gateway{loop, udp("ground"),
                        chip + R"("line": 0, "use": "power"}, )" + chip + R"("line": 1, "use": "link_up", "link": "ground"})"};
    EXPECT_TRUE(sim.level(0) && sim.level(1));
    sim.unplug();
    EXPECT_TRUE(loop.until([&] { return gateway.gpio(0)["state"] == "waiting" && gateway.gpio(1)["state"] == "waiting"; }));
    EXPECT_EQ(gateway.post(R"({"use": "power"})").status, 409u);
    sim.plug();
    EXPECT_TRUE(becomes(sim, 0, true));
    EXPECT_TRUE(becomes(sim, 1, true));
}

TEST_F(Gpio, a_pulse_that_the_chip_did_not_output_is_not_counted) {
    GpioSim sim{"a", 2};
    const std::string chip = "{\"chip\": \"" + sim.label() + "\", ";
    GpioGateway gateway{loop, udp("fc"),
                        chip + R"("line": 0, "use": "reset", "link": "fc"}, )" + chip + R"("line": 1, "use": "power"})"};
    sim.unplug();    // the gateway has not noticed yet
    const auto reset = gateway.post(R"({"use": "reset"})"), power = gateway.post(R"({"use": "power"})");
    EXPECT_EQ(reset.status, 409u) << reset.body;
    EXPECT_EQ(power.status, 409u) << power.body;
    EXPECT_EQ(gateway.gpio(0)["pulses"], 0);
    EXPECT_EQ(gateway.gpio(1)["pulses"], 0);
    sim.plug();
    EXPECT_TRUE(loop.until([&] { return gateway.gpio(0)["state"] == "held" && gateway.gpio(1)["state"] == "held"; }));
    EXPECT_FALSE(sim.level(0));
    EXPECT_TRUE(sim.level(1));
    EXPECT_EQ(gateway.post(R"({"use": "reset"})").status, 200u) << "the minute has not begun";
    EXPECT_TRUE(sim.level(0));
}

TEST_F(Gpio, post_reports_the_fault_of_a_request) {
    GpioSim sim{"a", 4};
    GpioGateway gateway{loop, udp("fc") + "," + udp("radio"),
                        line(sim, 0, R"("use": "reset", "link": "fc")") + "," +
                            line(sim, 1, R"("use": "power", "link": "radio")") + "," +
                            line(sim, 2, R"("use": "link_up", "link": "fc")")};
    const auto answer = [&](const std::string& body) {
        const auto reply = gateway.post(body);
        return std::to_string(reply.status) + " " + json::parse(reply.body).value("error", "");
    };
    EXPECT_EQ(answer("{}"), "400 2 GPIO lines match; select one by line, chip, link or use");
    EXPECT_EQ(answer(R"({"lin": 3})"), "400 unknown key 'lin' (did you mean 'line'?)");
    EXPECT_EQ(answer(R"({"line": true})"), "400 'line' must be text or a number");
    EXPECT_EQ(answer("[]"), "400 the body must be a JSON object such as {\"link\": \"fc\", \"use\": \"reset\"}");
    EXPECT_EQ(answer("{").substr(0, 4), "400 ");
    EXPECT_EQ(answer(R"({"link": "fd"})"), "404 no GPIO line matches; GET /status lists them under gpio");
    EXPECT_EQ(answer(R"({"line": 2})"), "400 only reset and power lines support actions");
    EXPECT_EQ(answer(R"({"link": "radio", "action": "pulse"})"),
              "400 the action must be pulse for a reset line or cycle for a power line, not 'pulse'");
    EXPECT_FALSE(sim.level(0));
    EXPECT_TRUE(sim.level(1));
    EXPECT_EQ(answer(R"({"link": "fc"})"), "200 ") << "one that can act";
    EXPECT_TRUE(sim.level(0));
}

TEST_F(Gpio, rs485_is_switched_to_sending_for_frames_and_to_receiving_after_them) {
    GpioSim sim{"a", 4};
    std::vector<std::string> ports;
    support::PtyDevice pty{dir / "port"};
    ports.push_back(pty.path());
    if (in_vm()) ports.push_back("/dev/ttyS1");    // a 16550, with /dev/ttyS2 at the other end
    for (const std::string& port : ports) {
        const int far = port == pty.path() ? -1 : ::open("/dev/ttyS2", O_RDWR | O_NOCTTY | O_NONBLOCK);
        if (far >= 0) {
            termios t{};
            ::tcgetattr(far, &t);
            ::cfmakeraw(&t);
            ::cfsetspeed(&t, B115200);
            ::tcsetattr(far, TCSANOW, &t);
        }
        const auto far_bytes = [&] {
            Bytes bytes(65536);
            const ssize_t n = ::read(far >= 0 ? far : pty.fd(), bytes.data(), bytes.size());
            return n > 0 ? static_cast<std::size_t>(n) : 0;
        };
        GpioGateway gateway{loop,
                            "{\"kind\": \"serial\", \"device\": \"" + port + R"(", "baud": 115200, "name": "bus"},)" + udp("app"),
                            line(sim, 0, R"("use": "rs485", "link": "bus")")};
        ASSERT_TRUE(loop.until([&] { return gateway.link("bus")["state"] == "up"; })) << gateway.link("bus");
        EXPECT_EQ(gateway.link("bus")["rs485"], "by a GPIO line") << "neither a pty nor a plain 16550 can do it by itself";
        UdpPeer app;
        std::size_t expected = 0, got = 0;
        for (int turn = 0; turn < 20; ++turn) {
            EXPECT_FALSE(sim.level(0)) << "nobody sends";
            const Bytes bytes = frame(0xFE, 0xFF, 0x03, Bytes(static_cast<std::size_t>(50 * turn)));
            app.send(gateway.port("app"), bytes);
            expected += bytes.size();
            // One event after the other: the first switches it, the second switches it back.
            ASSERT_TRUE(support::wait_until([&] { return sim.level(0); }, 10s,
                                            [&] {
                                                loop.io.restart();
                                                loop.io.run_one_for(2ms);
                                            }))
                << port << " " << turn;
            ASSERT_TRUE(becomes(sim, 0, false)) << port << " " << turn;
            if (far < 0) continue;
            // Everything was sent when the line is switched back: the far end has received what it has not read yet.
            loop.until([&] { return (got += far_bytes()) >= expected; }, 2s);
            EXPECT_EQ(got, expected) << turn;
        }
        EXPECT_GE(gateway.gpio()["edges"], 40);
        for (int i = 0; i < 50; ++i) app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03, Bytes(100)));
        EXPECT_TRUE(loop.until([&] {
            far_bytes();
            const json bus = gateway.link("bus");
            const int replaced = bus["superseded"].get<int>() + bus["stale"].get<int>();    // by newer ones, on a slow line
            return bus["frames_out"].get<int>() + replaced == 70;
        })) << gateway.link("bus");
        EXPECT_TRUE(loop.until([&] {
            far_bytes();
            return !sim.level(0);
        }));
        gateway.stop();
        EXPECT_FALSE(sim.level(0));
        if (far >= 0) ::close(far);
    }
}

}    // namespace
}    // namespace gpio_tests
