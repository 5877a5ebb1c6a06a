// Peers of a listening UDP port that send more broadcasts than the gateway can copy, and the effect on the commands of others.
// tests/README.md has the figures; ANOGATE_FLOOD=50000 is the rate of each peer in frames a second, ANOGATE_COMMANDS=1000 the
// number of commands.
#include <link/udp/udp_settings.hpp>
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <thread>

namespace network_flood_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

constexpr std::size_t floods = 16;
constexpr std::size_t frames_of_datagram = 60;

int from_environment(const char* name, int otherwise) {
    const char* text = std::getenv(name);
    return text ? std::atoi(text) : otherwise;
}

/// Broadcast telemetry of one address, each frame different.
class Talker {
public:
    explicit Talker(std::uint8_t source) : source_{source} {}
    void join(std::uint16_t port) { peer_.send(port, next(1)); }
    void talk(std::uint16_t port) { peer_.send(port, next(frames_of_datagram)); }

private:
    Bytes next(std::size_t frames) {
        Bytes all;
        for (; frames > 0; --frames, ++n_) {
            Bytes data(13, 7);
            for (std::size_t i = 0; i < 4; ++i) data[i] = static_cast<std::uint8_t>(n_ >> 8 * i);
            all = all + frame(source_, 0xFF, 0xF1, data);
        }
        return all;
    }
    UdpPeer peer_;
    std::uint8_t source_;
    std::uint32_t n_ = 0;
};

anogate::LinkSettings ground_link() {
    auto link = udp_listen("ground");
    link.as<anogate::UdpListenSettings>().max_peers = 24;    // a quarter is reserved for others
    return link;
}
anogate::LinkSettings air_link() {
    auto link = udp_listen("air");
    link.broadcast = false;
    return link;
}

/// Bytes of memory that unread datagrams use in the kernel.
std::uint64_t unread_at(std::uint16_t port) {
    std::ifstream sockets{"/proc/net/udp"};
    std::string line;
    while (std::getline(sockets, line)) {
        unsigned local = 0;
        unsigned long sending = 0, unread = 0;
        if (std::sscanf(line.c_str(), "%*d: %*x:%x %*x:%*x %*x %lx:%lx", &local, &sending, &unread) == 3 && local == port)
            return unread;
    }
    return 0;
}

struct Flood : testing::Test {
    Flood() {
        for (std::size_t i = 0; i < floods; ++i) talkers.push_back(std::make_unique<Talker>(static_cast<std::uint8_t>(30 + i)));
        for (const std::uint8_t n : Bytes{1, 2})    // a device that sent a single frame is forgotten after 10 s
            fc.send(daemon.port("air"), frame(0xDC, 0xFE, 0xF1, Bytes(10, n)));
        pilot.send(ground, vendor::who_are_you);
        for (auto& talker : talkers) talker->join(ground);
        EXPECT_TRUE(daemon.until(
            [&] { return daemon.link("ground").at("channels").size() == floods + 1 && daemon.count("air", "frames_in") == 2; }));
        fc.forget();
    }
    void command(std::uint16_t n) {
        pilot.send(ground, frame(0xFE, 0xDC, 0xC0, {16, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)}));
    }
    /// The numbers of the commands received since the last call.
    std::vector<std::uint16_t> carried_out() {
        std::vector<std::uint16_t> numbers;
        for (const Bytes& one : fc.frames())
            if (one[3] == 0xC0) numbers.push_back(static_cast<std::uint16_t>(one[7] | one[8] << 8));
        return numbers;
    }

    RunningGateway daemon{ground_link(), air_link()};
    std::uint16_t ground = daemon.port("ground");
    UdpPeer fc, pilot;
    std::vector<std::unique_ptr<Talker>> talkers;
};

TEST_F(Flood, a_command_does_not_wait_for_copies_of_broadcasts_that_others_sent_earlier) {
    const std::uint64_t before = daemon.count("ground", "frames_in");
    for (int i = 0; i < 8; ++i)
        for (auto& talker : talkers) talker->talk(ground);
    command(1);
    ASSERT_TRUE(daemon.until([&] { return carried_out().size() == 1; }));
    EXPECT_LT(daemon.count("ground", "frames_in") - before, floods * 8 * frames_of_datagram / 2);
}

TEST_F(Flood, only_datagrams_of_senders_above_their_share_are_lost) {
    constexpr std::uint16_t rounds = 30;
    std::vector<std::uint16_t> numbers;
    const auto read = [&] {
        for (const std::uint16_t n : carried_out()) numbers.push_back(n);
    };
    for (std::uint16_t n = 0; n < rounds; ++n) {
        for (int i = 0; i < 6; ++i)
            for (auto& talker : talkers) talker->talk(ground);
        command(n);
        daemon.io().restart();
        daemon.io().poll_one();
        daemon.io().poll_one();
        while (unread_at(ground) > 100'000) daemon.io().poll_one();    // the kernel has room for those of another round
        read();
    }
    ASSERT_TRUE(daemon.until([&] { return read(), numbers.size() == rounds; })) << numbers.size();
    EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
    EXPECT_GT(daemon.count("ground", "over_share"), 0u);
    EXPECT_EQ(daemon.link("ground").at("kernel_drops"), 0);
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST_F(Flood, no_command_is_lost_at_real_rates) {
    using Clock = std::chrono::steady_clock;
    const int rate = from_environment("ANOGATE_FLOOD", 2000), commands = from_environment("ANOGATE_COMMANDS", 50);
    std::atomic<bool> ends{false};
    std::vector<Clock::time_point> sent(static_cast<std::size_t>(commands));
    std::thread others{[&] {
        const auto began = Clock::now();
        double done = 0;    // frames of each peer
        while (!ends) {
            const double due = std::chrono::duration<double>(Clock::now() - began).count() * rate;
            for (; done + frames_of_datagram <= due && !ends; done += frames_of_datagram)
                for (auto& talker : talkers) talker->talk(ground);
            std::this_thread::sleep_for(500us);
        }
    }};
    std::thread operator_thread{[&] {
        for (std::size_t n = 0; n < sent.size(); ++n) {
            std::this_thread::sleep_for(10ms);
            sent[n] = Clock::now();
            command(static_cast<std::uint16_t>(n));
        }
    }};
    std::vector<double> waits;
    const bool all = daemon.until(
        [&] {
            for (const std::uint16_t n : carried_out())
                waits.push_back(std::chrono::duration<double, std::milli>(Clock::now() - sent[n]).count());
            return waits.size() == sent.size();
        },
        30s + 20ms * commands);
    ends = true;
    others.join();
    operator_thread.join();
    EXPECT_TRUE(all) << waits.size() << " of " << sent.size();
    EXPECT_EQ(daemon.link("ground").at("kernel_drops"), 0);
    std::sort(waits.begin(), waits.end());
    if (!waits.empty()) RecordProperty("p99_ms", std::to_string(waits[waits.size() * 99 / 100]));
}

}    // namespace
}    // namespace network_flood_tests
