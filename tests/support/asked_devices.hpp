// For tests of anoctl's device commands: a gateway with a simulated flight controller (0xDC) and a second device of the test
// (0xDD).
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
    /// The lines of an output with --json, parsed.
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
    /// Runs anoctl to its end. Its standard input is not a terminal.
    Ran anoctl(std::vector<std::string> words) {
        words.insert(words.end(), {"--control", socket});
        Process process{ANOCTL, std::move(words)};
        const int exit = process.wait();
        return {exit, process.output()};
    }
    /// A frame that the second device sends unrequested.
    static Bytes frame_of_another() { return frame(0xDD, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}); }
    /// Makes the second device known to the gateway. It never answers.
    void hear_of_another() {
        ASSERT_TRUE(wait_until([&] {
            peer.send(gateway.port("peer"), frame_of_another());
            return contains(anoctl({"devices"}).output, "0xDD");
        }));
    }

    /// True if the second device received a question.
    bool is_asked() {
        const auto frames = split(peer.heard()).frames;
        return std::any_of(frames.begin(), frames.end(), [](const Bytes& one) { return one[2] == 0xDD && one[3] == 0xE0; });
    }

    /// Waits until the gateway has received from the device whether it flies, after the commands sent so far.
    void receive_mode() { ASSERT_EQ(anoctl({"monitor", "--id", "mode", "--count", "1"}).exit, 0); }

    TempDir dir;
    std::string socket = dir / "control.sock";
    UdpPeer peer;
    Daemon gateway{ANOGATED, socket, {"sim:fc,name=fc", peer.link("peer")}};
};

/// Here the second device answers while the test waits for a process that uses it.
class AnsweringDevice : public DeviceGateway {
protected:
    AnsweringDevice() { fake.address = 0xDD; }
    /// Sends the second device's answers to the frames that it has received.
    void answer() {
        if (!port_) port_ = gateway.port("peer");    // kept: the gateway may end before its frames were read
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
    /// Runs a command of anoctl for the second device to its end.
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
