// anoctl's commands for devices, asked of a gateway with a simulated flight controller (0xDC) and a second device of the tests (0xDD).
#pragma once
#include "bytes.hpp"
#include "fake_loader.hpp"
#include "process.hpp"
#include "temp_dir.hpp"
#include "udp_peer.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace support {

class DeviceGateway : public testing::Test {
public:
    struct Ran {
        int exit = -1;
        std::string output;
    };
    /// What was written with --json.
    static std::vector<nlohmann::json> lines_of(const std::string& text) {
        std::vector<nlohmann::json> all;
        std::istringstream in{text};
        for (std::string line; std::getline(in, line);) all.push_back(nlohmann::json::parse(line));
        return all;
    }
    static bool contains(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

protected:
    void SetUp() override {
        ASSERT_TRUE(gateway.until_answers()) << gateway.output();
        ASSERT_TRUE(
            gateway.until([](const nlohmann::json& status) { return status.dump().find("\"0xDC\"") != std::string::npos; }));
    }
    /// Standard input is no terminal.
    Ran anoctl(std::vector<std::string> words) {
        words.insert(words.end(), {"--control", socket});
        Process process{ANOCTL, std::move(words)};
        const int exit = process.wait();
        return {exit, process.output()};
    }
    /// What a second device says unasked.
    static Bytes frame_of_another() { return frame(0xDD, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}); }
    /// It is known, and never answers.
    void hear_of_another() {
        ASSERT_TRUE(wait_until([&] {
            peer.send(gateway.port("peer"), frame_of_another());
            return contains(anoctl({"devices"}).output, "0xDD");
        }));
    }

    /// The second device was sent a question.
    bool is_asked() {
        const auto frames = split(peer.heard()).frames;
        return std::any_of(frames.begin(), frames.end(), [](const Bytes& one) { return one[2] == 0xDD && one[3] == 0xE0; });
    }

    /// The gateway has heard whether the device flies since it was told anything.
    void hear_whether_it_flies() { ASSERT_EQ(anoctl({"monitor", "--id", "mode", "--count", "1"}).exit, 0); }

    TempDir dir;
    std::string socket = dir / "control.sock";
    UdpPeer peer;
    Daemon gateway{ANOGATED, socket, {"sim:fc,name=fc", peer.link("peer")}};
};

/// The second device answers, as long as somebody waits for what it has to do with.
class AnsweringDevice : public DeviceGateway {
protected:
    AnsweringDevice() { fake.address = 0xDD; }
    /// The second device answers what came.
    void answer() {
        if (!port_) port_ = gateway.port("peer");    // the gateway may end before what it sent was read
        for (const Bytes& one : peer.frames())
            if (one[2] == 0xDD || one[2] == 0xFF)
                for (const Bytes& said : fake.take(ano::FrameView{one})) peer.send(*port_, said);
    }
    int until_ended(
        Process& process, const std::function<void()>& meanwhile = [] {}) {
        EXPECT_TRUE(wait_until([&] {
            answer();
            meanwhile();
            return !process.is_running();
        }));
        return process.wait();
    }
    /// A command for the second device, until it has ended.
    Ran asked(std::vector<std::string> words) {
        words.insert(words.end(), {"--device", "0xDD", "--control", socket});
        Process process{ANOCTL, std::move(words)};
        const int exit = until_ended(process);
        return {exit, process.output()};
    }

    FakeDevice fake;

private:
    std::optional<std::uint16_t> port_;
};

}    // namespace support
