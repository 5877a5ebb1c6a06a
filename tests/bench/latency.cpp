// The latency of light traffic through anogated and through a bare loop, alternating.
#include "forwarder.hpp"
#include "goals.hpp"

#include <chrono>
#include <functional>
#include <optional>

namespace bench {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr int rounds = 20;
constexpr std::uint64_t frames_a_round = 1000;    // through each

// Microseconds from sending to receiving one frame; std::nullopt: it did not arrive.
std::optional<double> travel_time(const Socket& sender, const Socket& taker, std::uint64_t number) {
    const auto bytes = frame(0x30, target, number);
    const auto sent = steady_clock::now();
    sender.send(bytes);
    if (!taker.wait_for(bytes, 100ms)) return std::nullopt;
    return std::chrono::duration<double, std::micro>(steady_clock::now() - sent).count();
}

// Only the measured processes have real-time priority: this thread polls without pause, and would block kernel threads.
Forwarder undisturbed(const std::function<Forwarder()>& start) {
    const Undisturbed undisturbed;
    return start();
}

}    // namespace

void measure_latency(Run& run) {
    const Forwarder ours = undisturbed([&] { return anogated_from_udp(run.anogated, 1, ""); });
    const Forwarder bare = undisturbed([] { return bare_from_udp(1); });
    Socket to_ours, to_bare;
    to_ours.connect(ours.port);
    to_bare.connect(bare.port);
    std::vector<double> our_median, our_99, bare_median, bare_99;
    auto next = steady_clock::now();
    for (int round = 0; round < rounds; ++round) {
        std::vector<double> a, b;
        for (std::uint64_t n = 0; n < frames_a_round; ++n) {
            if (const auto time = travel_time(to_ours, *ours.takers[0], n)) a.push_back(*time);
            std::this_thread::sleep_until(next += 500us);
            if (const auto time = travel_time(to_bare, *bare.takers[0], n)) b.push_back(*time);
            std::this_thread::sleep_until(next += 500us);
        }
        our_median.push_back(quantile(a));
        bare_median.push_back(quantile(b));
        our_99.push_back(quantile(a, 0.99));
        bare_99.push_back(quantile(b, 0.99));
    }
    run.table.compare("Latency at 1000 frames/s, UDP to UDP: median, µs, beside a bare poll loop", our_median, bare_median,
                      at_most(1.25));
    run.table.compare("Latency at 1000 frames/s, UDP to UDP: 99th percentile, µs, beside a bare poll loop", our_99, bare_99,
                      at_most(1.25));
}

}    // namespace bench
