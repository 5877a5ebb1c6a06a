// anogate-ros2 beside a gateway, with subscribers and publishers of CycloneDDS, in a network of their own.
#pragma once
#include <support/bytes.hpp>
#include <support/namespaces.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#ifndef ANOGATE_ROS2
#define ANOGATE_ROS2 ""
#endif
#ifndef LISTENER
#define LISTENER ""
#define TALKER ""
#endif
#ifndef FAST_LISTENER
#define FAST_LISTENER ""
#endif

/// Skips the test, with the reason, where its parts are not available.
#define ANOGATE_NEEDS_ROS2()                                                                                             \
    if (std::string{ANOGATE_ROS2}.empty()) GTEST_SKIP() << "anogate-ros2 was not built (libfastrtps-dev)";               \
    if (std::string{LISTENER}.empty()) GTEST_SKIP() << "CycloneDDS is not installed (cyclonedds-dev, cyclonedds-tools)"; \
    ANOGATE_NEEDS_NAMESPACES()

namespace ros2_tests {

using namespace std::chrono_literals;
using Seconds = std::chrono::duration<double>;
using Steady = std::chrono::steady_clock;

inline std::string cyclone_on(const std::string& interface) {
    return "CYCLONEDDS_URI=<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"" + interface +
           "\" multicast=\"true\"/></Interfaces></General></Domain></CycloneDDS>";
}

/// Fast DDS 2.9 deletes a statistics writer with the size of another class, which AddressSanitizer would end the program for.
inline std::vector<std::string> bridge_environment() {
    return {"ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1:new_delete_type_mismatch=0"};
}

struct Heard {
    std::string topic;
    std::uint64_t received_ns = 0, sent_ns = 0;
    nlohmann::json values;
};

/// A subscriber of CycloneDDS, or of Fast DDS on lo.
class Listener {
public:
    enum class Of { cyclone, fast };
    explicit Listener(std::vector<std::string> topics, const std::string& interface = "lo", Of of = Of::cyclone) {
        if (of == Of::fast) topics.insert(topics.begin(), "127.0.0.1");
        topics.insert(topics.begin(), "0");
        process_ = std::make_unique<support::Process>(of == Of::fast ? FAST_LISTENER : LISTENER, topics,
                                                      std::vector{cyclone_on(interface)});
    }
    /// Everything received so far.
    const std::vector<Heard>& heard() {
        std::istringstream lines{rest_ + process_->new_output()};
        rest_.clear();
        for (std::string line; std::getline(lines, line);) {
            if (lines.eof()) rest_ = line;
            else if (line.starts_with("matched ")) matched_.push_back(line.substr(8));
            else if (line.starts_with('/')) add(line);
        }
        return heard_;
    }
    std::size_t count(const std::string& topic) {
        std::size_t count = 0;
        for (const Heard& one : heard()) count += one.topic == topic ? 1u : 0u;
        return count;
    }
    bool until_count(const std::string& topic, std::size_t count, Steady::duration limit = support::patience) {
        return support::wait_until([&] { return this->count(topic) >= count; }, limit);
    }
    /// The topics for which it found a publisher, each with its USER_DATA.
    const std::vector<std::string>& matched() {
        heard();
        return matched_;
    }
    const support::Process& process() const { return *process_; }

private:
    void add(const std::string& line) {
        std::istringstream words{line};
        Heard one;
        std::string values;
        words >> one.topic >> one.received_ns >> one.sent_ns;
        std::getline(words, values);
        one.values = nlohmann::json::parse(values, nullptr, false);
        heard_.push_back(std::move(one));
    }

    std::unique_ptr<support::Process> process_;
    std::string rest_;
    std::vector<Heard> heard_;
    std::vector<std::string> matched_;
};

/// A publisher.
class Talker {
public:
    explicit Talker(const support::TempDir& dir, const std::string& name = "talker") : fifo_{dir / name} {
        ::mkfifo(fifo_.c_str(), 0600);
        shell_ = std::make_unique<support::Shell>("export '" + cyclone_on("lo") + "'; exec " TALKER " 0 <" + fifo_);
        input_.open(fifo_);
    }
    void say(const std::string& command) { input_ << command << std::endl; }

private:
    std::string fifo_;
    std::unique_ptr<support::Shell> shell_;
    std::ofstream input_;
};

class Bridged : public testing::Test {
protected:
    void SetUp() override { ANOGATE_NEEDS_ROS2(); }

    void start_gateway(std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), {"--log-level", "warn"});
        gateway = std::make_unique<support::Daemon>(ANOGATED, socket, arguments);
        ASSERT_TRUE(gateway->until_answers()) << gateway->output();
    }
    /// With a device on the link `fc`, which is `device`.
    void start_gateway() { start_gateway({device.link("fc")}); }
    void start_bridge(const std::string& config = "{}", std::vector<std::string> more = {"--interface", "lo"}) {
        const std::string file = dir.write("ros2.json", config);
        std::vector<std::string> words{"--control", socket, "--config", file};
        words.insert(words.end(), more.begin(), more.end());
        bridge = std::make_unique<support::Process>(ANOGATE_ROS2, words, bridge_environment());
    }
    bool until_connected() { return bridge->until_says("connected to the gateway"); }
    void send(std::uint8_t id, const support::Bytes& data, std::uint8_t source = 5) {
        device.send(gateway->port("fc"), support::frame(source, 0xFE, id, data));
    }
    /// Sends the frame again and again until `holds`.
    bool send_until(std::uint8_t id, const support::Bytes& data, const std::function<bool()>& holds,
                    Steady::duration limit = support::patience) {
        const std::uint16_t port = gateway->port("fc");
        return support::wait_until(
            [&] {
                device.send(port, support::frame(5, 0xFE, id, data));
                return holds();
            },
            limit, [] { std::this_thread::sleep_for(10ms); });
    }

    support::TempDir dir;
    std::string socket = dir / "control.sock";
    support::NetworkNamespace net;
    support::UdpPeer device;
    std::unique_ptr<support::Daemon> gateway;
    std::unique_ptr<support::Process> bridge;
};

}    // namespace ros2_tests
