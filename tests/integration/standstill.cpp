// After a stall the gateway does not send old commands that had waited for it.
#include <support/files.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <thread>

namespace standstill_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

constexpr std::uint8_t command = 0xC0, sticks = 0x41, telemetry = 0x03;
constexpr auto max_age = "1s";
constexpr auto longer = 1200ms;

Bytes numbered(std::uint8_t source, std::uint8_t id, std::uint8_t n) { return frame(source, 0xDC, id, Bytes(14, n)); }

/// Two inputs, a UDP port and a pty, and one output.
class Standstill : public testing::Test {
protected:
    Standstill() : daemon{ANOGATED, dir / "control", {"--config", configuration()}} {}

    void SetUp() override {
        ASSERT_TRUE(daemon.until_up("ground"));
        ground_port = daemon.port("ground");
        app.emplace(dir / "app");
        ASSERT_TRUE(daemon.until_up("app"));
        ground.send(ground_port,
                    numbered(0xFE, command, 250));    // no bytes that are repeated on another link: they would cause a probe
        other.send(ground_port, numbered(40, telemetry, 250));
        app->write(numbered(0xFE, command, 251));
        ASSERT_TRUE(wait_until([&] { return split(taker.heard()).frames.size() == 3; }));
        taker.forget();
    }

    void stand_still_with(const std::function<void()>& what, std::chrono::milliseconds time = longer) {
        daemon.signal(SIGSTOP);
        ASSERT_TRUE(wait_until([&] { return state() == 'T'; }));
        what();
        std::this_thread::sleep_for(time);
    }
    void go_on() { daemon.signal(SIGCONT); }

    char state() const {
        std::ifstream file{"/proc/" + std::to_string(daemon.pid()) + "/stat"};
        std::string line;
        std::getline(file, line);
        const auto end = line.rfind(')');
        return end + 2 < line.size() ? line[end + 2] : '?';
    }
    std::string configuration() {
        const nlohmann::json age{{"control", "200ms"}, {"telemetry", max_age}, {"rest", max_age}};
        const nlohmann::json json{
            {"links",
             {{{"name", "ground"}, {"kind", "udp-listen"}, {"address", "127.0.0.1:0"}, {"peer_timeout", "1s"}},
              {{"name", "app"}, {"kind", "pty"}, {"path", dir / "app"}},
              {{"name", "out"}, {"kind", "udp"}, {"address", taker.local().text()}, {"age", age}}}}};
        const std::string path = dir / "anogate.json";
        std::ofstream{path} << json;
        return path;
    }
    std::uint64_t stale() { return daemon.count("out", "stale"); }

    const TempDir dir;
    UdpPeer taker, ground, other;
    Daemon daemon;
    std::uint16_t ground_port = 0;
    std::optional<PortUser> app;
};

TEST_F(Standstill, ages_udp_frames_from_their_time_of_arrival) {
    stand_still_with([&] {
        for (std::uint8_t n = 0; n < 40; ++n)
            for (const std::uint8_t id : {command, sticks, telemetry}) ground.send(ground_port, numbered(0xFE, id, n));
    });
    ground.send(ground_port, numbered(0xFE, command, 100));
    go_on();
    EXPECT_TRUE(wait_until([&] { return !taker.heard().empty(); }));
    EXPECT_EQ(taker.heard(), numbered(0xFE, command, 100));
    EXPECT_TRUE(wait_until([&] { return stale() == 120; })) << stale();
    EXPECT_EQ(taker.heard(), numbered(0xFE, command, 100));
}

TEST_F(Standstill, ages_frames_from_a_terminal_by_the_whole_standstill) {
    std::uint64_t sent = 0;
    stand_still_with([&] {
        for (std::uint8_t n = 0; n < 200; ++n)    // more than one read of a terminal returns
            for (const std::uint8_t id : {command, sticks, telemetry})
                if (const Bytes f = numbered(0xFE, id, n); app->write(f) == f.size()) ++sent;
    });
    go_on();
    EXPECT_TRUE(wait_until([&] { return stale() == sent; })) << stale() << " of " << sent;
    EXPECT_GT(sent, 400u);
    app->write(numbered(0xFE, sticks, 201));
    EXPECT_TRUE(wait_until([&] { return taker.heard() == numbered(0xFE, sticks, 201); }));
}

TEST_F(Standstill, frames_of_a_program_that_connected_meanwhile_are_stale_too) {
    app.reset();
    ASSERT_TRUE(daemon.until([&](const auto&) { return daemon.link("app").at("state") == "waiting"; }));
    stand_still_with([&] { PortUser{dir / "app"}.write(numbered(0xFE, command, 7)); });
    go_on();
    EXPECT_TRUE(wait_until([&] { return daemon.count("app", "frames_in") == 2; }));
    app.emplace(dir / "app");
    ASSERT_TRUE(daemon.until_up("app"));
    app->write(numbered(0xFE, command, 8));
    EXPECT_TRUE(wait_until([&] { return !taker.heard().empty(); }));
    EXPECT_EQ(taker.heard(), numbered(0xFE, command, 8));
}

TEST_F(Standstill, is_reported_in_the_log_and_the_status) {
    EXPECT_EQ(daemon.status().at("gateway").at("standstills"), 0);
    stand_still_with([] {}, 1700ms);
    go_on();
    EXPECT_TRUE(daemon.until_says("stalled for at least 1."));
    const auto gateway = daemon.status().at("gateway");
    EXPECT_EQ(gateway.at("standstills"), 1);
    EXPECT_GT(gateway.at("longest_standstill_s"), 1.0);
}

TEST_F(Standstill, each_of_two_in_a_row_is_logged) {
    for (const auto& [time, words] :
         {std::pair{700ms, "stalled for at least 0."}, std::pair{1700ms, "stalled for at least 1."}}) {
        stand_still_with([&] { ground.send(ground_port, numbered(0xFE, command, 5)); }, time);
        go_on();
        EXPECT_TRUE(daemon.until_says(words));
    }
}

TEST_F(Standstill, of_half_a_second_is_reported_if_a_stream_sent_meanwhile) {
    app->write(numbered(0xFE, command, 2));
    ASSERT_TRUE(wait_until([&] { return split(taker.heard()).frames.size() == 1; }));
    stand_still_with([&] { app->write(numbered(0xFE, command, 3)); }, 520ms);
    go_on();
    EXPECT_TRUE(daemon.until_says("stalled for at least 0."));
    EXPECT_EQ(daemon.status().at("gateway").at("standstills"), 1);
}

TEST_F(Standstill, of_half_a_second_is_reported_if_datagrams_waited) {
    app.reset();
    ASSERT_TRUE(daemon.until([&](const auto&) { return daemon.link("app").at("state") == "waiting"; }));
    stand_still_with([&] { ground.send(ground_port, numbered(0xFE, command, 4)); }, 520ms);
    go_on();
    EXPECT_TRUE(daemon.until_says("stalled for at least 0."));
    EXPECT_EQ(daemon.status().at("gateway").at("standstills"), 1);
}

TEST_F(Standstill, does_not_remove_peers_that_sent_meanwhile) {
    stand_still_with(
        [&] {
            for (int n = 0; n < 100; ++n) ground.send(ground_port, numbered(0xFE, command, 1));    // more than one read accepts
            other.send(ground_port, numbered(40, telemetry, 1));
        },
        2100ms);
    go_on();
    EXPECT_TRUE(wait_until([&] { return daemon.count("ground", "frames_in") == 103; }));
    EXPECT_EQ(daemon.link("ground").at("channels").size(), 2u);
    EXPECT_EQ(daemon.output().find("is gone"), std::string::npos);
}

}    // namespace
}    // namespace standstill_tests
