// A sender of questions that a device never answers, and the answers that others get meanwhile. tests/README.md has the figures.
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <memory>

namespace questions_tests {
namespace {

using namespace support;

// Values of parameters that the device does not have, so that it does not answer.
Bytes nonsense(std::uint16_t n) {
    return frame(0xFE, 0xDC, 0xE0, {2, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(0xC0 | n >> 8)});
}

TEST(Questions, of_twelve_peers_that_stay_unanswered_do_not_block_requests_of_the_gateway) {
    TempDir dir;
    const std::string socket = dir / "control.sock";
    Daemon gateway{ANOGATED, socket, {"sim:fc,name=fc,profile=vendor", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(gateway.until([](const nlohmann::json& status) { return status.dump().find("\"0xDC\"") != std::string::npos; }))
        << gateway.output();
    const std::uint16_t port = gateway.port("ground");
    std::vector<std::unique_ptr<UdpPeer>> peers;
    for (int i = 0; i < 12; ++i) peers.push_back(std::make_unique<UdpPeer>());
    std::uint16_t n = 0;
    const auto ask = [&] {
        for (auto& peer : peers)
            for (int i = 0; i < 8; ++i) peer->send(port, nonsense(static_cast<std::uint16_t>(n++ % 0x3FFF)));
    };
    ask();
    Process list{ANOCTL, {"param", "list", "--control", socket}};
    ASSERT_TRUE(wait_until([&] {
        ask();
        return !list.is_running();
    }));
    EXPECT_EQ(list.wait(), 0) << list.output();
    EXPECT_NE(list.output().find("SIM_HEIGHT"), std::string::npos) << list.output();
}

TEST(Questions, of_one_peer_that_stay_unanswered_use_one_slot_while_another_peer_waits) {
    TempDir dir;
    Daemon gateway{ANOGATED, dir / "control.sock", {"sim:fc,name=fc,profile=vendor", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(gateway.until([](const nlohmann::json& status) { return status.dump().find("\"0xDC\"") != std::string::npos; }))
        << gateway.output();
    const std::uint16_t port = gateway.port("ground");
    UdpPeer attacker, host;
    for (std::uint16_t n = 0; n < 100; ++n) attacker.send(port, nonsense(n));
    const auto began = std::chrono::steady_clock::now();
    int answers = 0;
    for (std::uint8_t n = 1; n <= 20; ++n) {
        host.send(port, frame(0xFE, 0xDC, 0xE0, {2, n, 0}));
        ASSERT_TRUE(wait_until([&] {
            for (const Bytes& one : host.frames()) answers += one[3] == 0xE1 ? 1 : 0;
            return answers == n;
        })) << int{n};
    }
    // 100 questions in groups of eight, half a second for each group, are 6 s.
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds{5});
}

}    // namespace
}    // namespace questions_tests
