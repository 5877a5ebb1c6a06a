// A serial line that is offered four times its capacity.
#include "forwarder.hpp"
#include "goals.hpp"
#include "slow_line.hpp"

#include <chrono>
#include <cstring>
#include <mutex>
#include <random>

namespace bench {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr double rate = 11520;    // bytes/s: 115200 baud, 8N1
constexpr unsigned kinds = 15;    // of telemetry: 0x01 to 0x0F
constexpr std::uint8_t urgent = 0xE1;
constexpr int rounds = 5;
constexpr auto measured = 3s;

std::uint64_t now() { return static_cast<std::uint64_t>(steady_clock::now().time_since_epoch() / 1ns); }

// The age of the frames that leave the line, in ms: their DATA contains the time at which they were sent.
class Ages {
public:
    void note(ano::FrameView frame) {
        std::uint64_t sent;
        std::memcpy(&sent, frame.data().data(), sizeof sent);
        const std::scoped_lock lock{mutex_};
        (frame.id() == urgent ? urgent_ : telemetry_).push_back(static_cast<double>(now() - sent) / 1e6);
    }
    struct Percentiles {
        double urgent, telemetry;
    };
    Percentiles pop_percentiles() {
        const std::scoped_lock lock{mutex_};
        return {quantile(std::exchange(urgent_, {}), 0.98), quantile(std::exchange(telemetry_, {}), 0.98)};
    }

private:
    std::mutex mutex_;
    std::vector<double> urgent_, telemetry_;
};

// Telemetry at four times the rate, and an urgent frame every 20 to 80 ms.
void offer(const Socket& socket, const std::atomic<bool>& stop) {
    std::mt19937 random{1};
    const auto begin = steady_clock::now();
    auto next_urgent = begin;
    std::uint64_t sent = 0;
    while (!stop) {
        std::this_thread::sleep_for(500us);
        const std::chrono::duration<double> elapsed = steady_clock::now() - begin;
        const auto due = static_cast<std::uint64_t>(elapsed.count() * 4 * rate / frame_size);
        for (; sent < due; ++sent) socket.send(frame(0xDC, target, now(), static_cast<std::uint8_t>(1 + sent % kinds)));
        if (steady_clock::now() < next_urgent) continue;
        socket.send(frame(0xDC, target, now(), urgent));
        next_urgent += 20ms + random() % 60 * 1ms;
    }
}

}    // namespace

void measure_line(Run& run) {
    const Undisturbed undisturbed;
    Ages ages;
    SlowLine line{rate, [&](ano::FrameView frame) { ages.note(frame); }};
    const GatewayProcess gateway{
        run.anogated,
        {"--route", "0x42=line", "udp-listen:127.0.0.1:0,name=in", "serial:" + line.path() + ",baud=115200,pace=on,name=line"}};
    Socket socket;
    socket.connect(gateway.port("in"));
    std::atomic<bool> stop{false};
    std::thread sender{[&] { offer(socket, stop); }};
    std::this_thread::sleep_for(1s);
    ages.pop_percentiles();
    std::vector<double> urgent_98, telemetry_98, used;
    for (int round = 0; round < rounds; ++round) {
        const SlowLine::Count before = line.count();
        std::this_thread::sleep_for(measured);
        const SlowLine::Count after = line.count();
        used.push_back(100 * static_cast<double>(after.carried - before.carried) /
                       static_cast<double>(after.possible - before.possible));
        const Ages::Percentiles age = ages.pop_percentiles();
        urgent_98.push_back(age.urgent);
        telemetry_98.push_back(age.telemetry);
    }
    stop = true;
    sender.join();
    run.table.measure("Serial at 115200, offered four times that: urgent frames, 98th percentile of their age, ms", urgent_98,
                      at_most(45));
    run.table.measure("… delivered telemetry, 98th percentile of its age, ms", telemetry_98, at_most(80));
    run.table.measure("… line used, %", used, at_least(85));
    run.table.measure("… most that waited in the driver, ms (`latency` is 20)", {1e3 * line.max_waiting() / rate}, at_most(20));
    run.table.measure("… bytes damaged", {static_cast<double>(line.damaged())}, at_most(0));
}

}    // namespace bench
