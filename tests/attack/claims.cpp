// Senders that use the address of a device, and the frames that they get. tests/README.md has the figures.
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>

namespace claims_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

Bytes broadcast(std::uint8_t n) { return frame(0xDC, 0xFF, 0x03, {n, 1, 2, 3, 4, 5, 6}); }
Bytes command(std::uint8_t n) { return frame(0xFE, 0xDC, 0xC0, {16, 1, n}); }

/// Collects the warnings of the log while it exists.
class LogLines {
public:
    LogLines() {
        auto logger = std::make_shared<spdlog::logger>("told", std::make_shared<spdlog::sinks::ostream_sink_st>(log_));
        logger->set_pattern("%v");
        logger->set_level(spdlog::level::warn);
        spdlog::set_default_logger(std::move(logger));
    }
    ~LogLines() { spdlog::set_default_logger(before_); }
    LogLines(const LogLines&) = delete;
    LogLines& operator=(const LogLines&) = delete;
    /// Returns the lines since the last call, without those about a busy machine.
    std::string take() const {
        std::istringstream told{log_.str()};
        log_.str({});
        std::string lines;
        for (std::string line; std::getline(told, line);)
            if (!line.starts_with("stalled for ")) lines += line + '\n';
        return lines;
    }

private:
    std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
    mutable std::ostringstream log_;
};

class Claims : public testing::Test {
protected:
    void SetUp() override {
        fc.send(daemon.port("air"), broadcast(0));
        pilot.send(daemon.port("ground"), vendor::who_are_you);
        ASSERT_TRUE(
            daemon.until([&] { return daemon.count("air", "frames_in") == 1 && daemon.count("ground", "frames_in") == 1; }));
    }
    /// `from` sends the frame to the ground link; true: it was routed.
    bool send(UdpPeer& from, const Bytes& bytes) { return send_on_link(from, "ground", bytes); }
    bool send_from_device(const Bytes& bytes) { return send_on_link(fc, "air", bytes); }
    bool send_on_link(UdpPeer& from, const std::string& link, const Bytes& bytes) {
        const auto before = daemon.count(link, "bytes_in");
        from.send(daemon.port(link), bytes);
        return daemon.until([&] { return daemon.count(link, "bytes_in") >= before + bytes.size(); });
    }
    static std::size_t count(UdpPeer& who, std::uint8_t id) {
        std::size_t n = 0;
        for (const Bytes& one : split(who.heard()).frames) n += one[3] == id;
        return n;
    }
    /// Answers like a device that was asked who it is and sends nothing else.
    void answer() {
        for (const std::size_t asked = questions(); answered < asked; ++answered)
            fc.send(daemon.port("air"), frame(0xDC, 0xFE, 0xE3, Bytes(15, 1)));
    }
    std::size_t questions() {
        std::size_t n = 0;
        for (const Bytes& one : split(fc.heard()).frames) n += one == frame(0xFE, 0xDC, 0xE0, {0, 0, 0});
        return n;
    }
    nlohmann::json conflict() {
        const auto conflicts = daemon.status().at("conflicts");
        return conflicts.size() == 1 ? conflicts.at(0) : nlohmann::json{};
    }

    RunningGateway daemon{udp_listen("ground"), udp_listen("air")};
    UdpPeer fc, pilot, attacker;
    std::size_t answered = 0;
};

TEST_F(Claims, quiet_device_keeps_its_address) {
    for (std::uint8_t n = 0; n < 40; ++n) {
        ASSERT_TRUE(send(attacker, broadcast(100 + n)) && send(pilot, command(n)));
        answer();
    }
    ASSERT_TRUE(daemon.until([&] {
        answer();
        return count(fc, 0xC0) == 40 && !conflict().is_null();
    }));
    EXPECT_EQ(count(attacker, 0xC0), 0u);
    EXPECT_EQ(questions(), 1u);
    EXPECT_EQ(count(attacker, 0xE0), 0u) << "it is not asked";
    EXPECT_EQ(conflict().at("links"), (nlohmann::json{"ground", "air"}));
    EXPECT_EQ(conflict().at("count"), 1);
    EXPECT_EQ(conflict().at("claimed_by"), (nlohmann::json{{"link", "ground"}, {"peer", attacker.local().text()}}));
    EXPECT_EQ(daemon.route("0xDC").at("links"), nlohmann::json{"air"});
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST_F(Claims, attacker_on_the_link_of_the_device_receives_no_commands_either) {
    ASSERT_TRUE(send_on_link(attacker, "air", broadcast(1)) && send(pilot, command(1)));
    ASSERT_TRUE(daemon.until([&] {
        answer();
        return count(fc, 0xC0) == 1 && !conflict().is_null();
    }));
    EXPECT_EQ(count(attacker, 0xC0), 0u);
    EXPECT_EQ(daemon.link("air").at("hint"),
              "two peers send as the same device: see `conflicts` in the status; if these are two devices, change the id of one "
              "(0xDC)");
}

// The device always sends the same bytes, and the attacker sent them first.
TEST_F(Claims, sender_that_repeats_a_device_from_new_ports_receives_none_of_its_commands) {
    std::vector<std::unique_ptr<UdpPeer>> ports;
    for (std::uint8_t n = 0; n < 70; ++n) {
        if (n % 7 == 0) {
            ports.push_back(std::make_unique<UdpPeer>());
            ASSERT_TRUE(send(*ports.back(), broadcast(200)));
        }
        ASSERT_TRUE(send_from_device(broadcast(200)) && send(pilot, command(n)));
    }
    ASSERT_TRUE(daemon.until([&] { return count(fc, 0xC0) == 70 && count(pilot, 0x03) >= 70; }))
        << count(fc, 0xC0) << ' ' << count(pilot, 0x03);
    for (auto& port : ports) EXPECT_EQ(count(*port, 0xC0), 0u);
    EXPECT_EQ(conflict().at("claimed_by").at("link"), "ground");
    EXPECT_TRUE(daemon.counters_add_up());
}

// The attacker sent the frame first; the device's own is forwarded, and the device answers no question.
TEST_F(Claims, device_frame_that_an_attacker_sent_first_still_counts_as_a_sign_of_life) {
    ASSERT_TRUE(send(attacker, broadcast(200)) && send_from_device(broadcast(200)));
    EXPECT_EQ(daemon.count("air", "looped"), 0u);
    EXPECT_GE(conflict().at("count"), 1);
    EXPECT_EQ(daemon.route("0xDC").at("links"), nlohmann::json{"air"});
}

TEST_F(Claims, copy_that_a_loop_may_have_caused_is_not_a_claim) {
    ASSERT_TRUE(send(attacker, vendor::who_are_you) && send_from_device(broadcast(200)) && send(attacker, broadcast(200)));
    EXPECT_EQ(daemon.count("ground", "looped"), 0u);
    EXPECT_EQ(questions(), 0u);
    ASSERT_TRUE(send_from_device(broadcast(201)));
    EXPECT_TRUE(daemon.status().at("conflicts").empty());
}

TEST_F(Claims, device_that_reappears_elsewhere_is_reached_after_it_stays_silent_on_its_old_link) {
    UdpPeer elsewhere;
    ASSERT_TRUE(send(elsewhere, broadcast(1)));
    const auto begin = anogate::Clock::now();
    ASSERT_TRUE(daemon.until([&] { return daemon.route("0xDC").at("links") == nlohmann::json{"ground"}; }));
    const auto took = anogate::Clock::now() - begin;
    EXPECT_GE(took, 2900ms);
    EXPECT_EQ(questions(), 3u);
    ASSERT_TRUE(send(pilot, command(1)));
    EXPECT_TRUE(daemon.until([&] { return count(elsewhere, 0xC0) == 1; }));
    EXPECT_EQ(count(fc, 0xC0), 0u);
    EXPECT_TRUE(daemon.status().at("conflicts").empty());
}

TEST_F(Claims, conflict_is_logged_once_with_the_claiming_sender) {
    const LogLines log;
    for (std::uint8_t n = 0; n < 5; ++n) EXPECT_TRUE(send(attacker, broadcast(100 + n)) && send_from_device(broadcast(n)));
    EXPECT_EQ(log.take(), "0xDC is seen on ground and air, claimed by ground (" + attacker.local().text() +
                              "): if these are two devices, change the id of one; or pin it: --route 0xDC=LINK\n");
}

// It answers no question, so it loses its address, but with a log line.
TEST_F(Claims, device_that_does_not_answer_loses_its_address_with_a_log_line) {
    const LogLines log;
    ASSERT_TRUE(send(attacker, broadcast(1)));
    EXPECT_FALSE(daemon.route("0xDC").contains("moved_from"));
    ASSERT_TRUE(daemon.until([&] { return daemon.route("0xDC").at("links") == nlohmann::json{"ground"}; }));
    EXPECT_EQ(daemon.route("0xDC").at("moved_from"), nlohmann::json{"air"});
    EXPECT_EQ(log.take(),
              "0xDC moved from air to ground: frames for it now go there. If the device is not connected there, pin it: "
              "--route 0xDC=air\n");
    ASSERT_TRUE(send_from_device(broadcast(2)));
    ASSERT_TRUE(daemon.until([&] { return daemon.route("0xDC").at("links") == nlohmann::json{"air"}; }));
    EXPECT_FALSE(daemon.route("0xDC").contains("moved_from"));
    EXPECT_NE(log.take().find("0xDC moved from ground to air"), std::string::npos);
}

TEST_F(Claims, host_is_reached_at_once_wherever_it_sends_from) {
    UdpPeer second;
    ASSERT_TRUE(send_on_link(second, "air", frame(0xFE, 0xFF, 0xC1, {0, 0, 0})) &&
                send_from_device(frame(0xDC, 0xFE, 0xE3, Bytes(15, 1))));
    EXPECT_TRUE(daemon.until([&] { return count(second, 0xE3) == 1 && count(pilot, 0xE3) == 1; }));
    EXPECT_EQ(questions(), 0u);
    EXPECT_TRUE(daemon.status().at("conflicts").empty());
}

// Its old port is closed, so there is nothing to ask.
TEST(Replugged, device_is_reached_at_its_new_port_at_once) {
    const TempDir dir;
    PtyDevice fc{dir / "ttyUSB0"}, again{dir / "ttyUSB1"};
    again.unplug();
    RunningGateway daemon{serial("usb0", fc.path()), serial("usb1", again.path()), udp_listen("ground")};
    ASSERT_TRUE(daemon.until_up("usb0"));
    UdpPeer pilot;
    pilot.send(daemon.port("ground"), vendor::who_are_you);
    fc.write(broadcast(0));
    ASSERT_TRUE(daemon.until([&] { return daemon.count("usb0", "frames_in") == 1 && daemon.count("ground", "frames_in") == 1; }));
    fc.unplug();
    again.plug();
    ASSERT_TRUE(daemon.until_waiting("usb0") && daemon.until_up("usb1"));
    again.write(broadcast(1));
    ASSERT_TRUE(daemon.until([&] { return daemon.count("usb1", "frames_in") == 1; }));
    EXPECT_EQ(daemon.route("0xDC").at("links"), nlohmann::json{"usb1"});
    pilot.send(daemon.port("ground"), command(1));
    EXPECT_TRUE(daemon.until([&] { return again.heard() == command(1); }));
    EXPECT_TRUE(daemon.status().at("conflicts").empty());
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(PinnedAddress, never_moves) {
    RunningGateway daemon{settings_of({udp_listen("ground"), udp_listen("air")}, {}, {{0xDC, 0xDC, "air"}})};
    UdpPeer attacker;
    const LogLines log;
    attacker.send(daemon.port("ground"), broadcast(1));
    ASSERT_TRUE(daemon.until([&] { return !daemon.status().at("conflicts").empty(); }));
    const std::string advice =
        "its route does not change; if it is one device, put both links in one `group`; if two, change the id of the other one";
    EXPECT_EQ(log.take(), "0xDC is pinned to air, and is claimed by ground (" + attacker.local().text() + "): " + advice + "\n");
    for (const char* link : {"ground", "air"})
        EXPECT_EQ(daemon.link(link).at("hint"), "frames from a pinned address arrive on another link: " + advice + " (0xDC)")
            << link;
    EXPECT_EQ(daemon.status().at("conflicts").at(0).at("claimed_by").at("peer"), attacker.local().text());
    EXPECT_EQ(daemon.route("0xDC").at("via"), "pinned");
}

}    // namespace
}    // namespace claims_tests
