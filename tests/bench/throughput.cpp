// The cost of a frame at full load: CPU time of the forwarding process.
#include "forwarder.hpp"
#include "goals.hpp"

#include <chrono>

namespace bench {
namespace {

using namespace std::chrono_literals;

constexpr int rounds = 12;
constexpr auto warm_up = 50ms;
constexpr auto measured = 300ms;

double frames_a_cpu_second(const Forwarder& forwarder, std::uint8_t destination) {
    std::unique_ptr<Flood> flood;
    if (forwarder.ptys) forwarder.ptys->start();
    else flood = std::make_unique<Flood>(forwarder.port, destination);
    std::this_thread::sleep_for(warm_up);
    const std::uint64_t frames_before = forwarder.frames();
    const double cpu_before = cpu_seconds(forwarder.pid());
    std::this_thread::sleep_for(measured);
    const double cpu = cpu_seconds(forwarder.pid()) - cpu_before;
    const auto frames = static_cast<double>(forwarder.frames() - frames_before);
    if (forwarder.ptys) forwarder.ptys->stop();
    return frames / cpu;
}

struct Sides {
    std::vector<double> ours, beside;
};

Sides measure_both(const Forwarder& ours, const Forwarder& beside, std::uint8_t destination = target) {
    std::vector<int> taken_at = ours.taken_at();
    for (const int fd : beside.taken_at()) taken_at.push_back(fd);
    const Sink sink{taken_at};
    Sides sides;
    for (int i = 0; i < rounds; ++i) {
        if (i % 2 == 0) sides.ours.push_back(frames_a_cpu_second(ours, destination));
        sides.beside.push_back(frames_a_cpu_second(beside, destination));
        if (i % 2 == 1) sides.ours.push_back(frames_a_cpu_second(ours, destination));
    }
    return sides;
}

}    // namespace

void measure_udp(Run& run) {
    const auto [ours, beside] = measure_both(anogated_from_udp(run.anogated, 1, unpacked), bare_from_udp(1));
    run.table.compare("UDP to UDP, a frame a datagram: frames a CPU second, beside a bare loop", ours, beside, at_least(0.80));
}

void measure_packed(Run& run) {
    const auto [ours, beside] = measure_both(anogated_from_udp(run.anogated, 1, ""), bare_from_udp(1, mtu));
    run.table.compare("UDP to UDP, packed: frames a CPU second, beside a bare packing loop", ours, beside, at_least(0.75));
}

void measure_pty(Run& run) {
    const auto [ours, beside] = measure_both(anogated_from_pty(run.anogated), anogated_from_udp(run.anogated, 1, unpacked));
    run.table.compare("pty to UDP, packed: frames a CPU second, beside its own UDP to UDP unpacked", ours, beside, at_least(5));
}

void measure_broadcast(Run& run) {
    auto [ours, beside] = measure_both(anogated_from_udp(run.anogated, 8, unpacked), bare_from_udp(8), everybody);
    for (double& value : ours) value = 1e6 / value;
    for (double& value : beside) value = 1e6 / value;
    run.table.compare("Broadcast to 8 UDP peers: CPU µs a frame, beside a bare loop that sends 8 times", ours, beside,
                      at_most(1.3));
}

}    // namespace bench
