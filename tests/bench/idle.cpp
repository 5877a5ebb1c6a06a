// The cost of an idle anogated, and the number of its system calls under load.
#include "forwarder.hpp"
#include "goals.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace bench {

using namespace std::chrono_literals;

// With all reasons for a link to wait: absent devices, an address that no interface has, a terminal that was not opened.
void measure_idle(Run& run) {
    const std::string path = "/tmp/anogate-bench-" + std::to_string(::getpid());
    const GatewayProcess gateway{run.anogated,
                                 {"udp-listen:127.0.0.1:0", "udp:127.0.0.1:9", "serial:/dev/anogate-absent-1",
                                  "serial:/dev/anogate-absent-2", "udp-listen:192.0.2.1:0,name=absent-3", "pty:" + path}};
    std::this_thread::sleep_for(2s);
    std::vector<double> a_second;
    for (int i = 0; i < 4; ++i) {
        const std::uint64_t before = wake_ups(gateway.pid());
        std::this_thread::sleep_for(2s);
        a_second.push_back(static_cast<double>(wake_ups(gateway.pid()) - before) / 2);
    }
    run.table.measure("Idle, three links absent: wake-ups a second", a_second, at_most(3));
    run.table.measure("… resident memory, MB", {static_cast<double>(resident_bytes(gateway.pid())) / 1e6}, at_most(12));
}

namespace {

// The total reported by strace, which it writes shortly after the end of the traced process. 0: there is none.
double traced_calls(const std::string& path) {
    for (int i = 0; i < 500; ++i) {
        std::this_thread::sleep_for(10ms);
        std::ifstream summary{path};
        double calls = 0;
        for (std::string line; std::getline(summary, line);)
            if (line.ends_with(" total")) calls = std::atof(line.c_str());
        if (calls > 0) return calls;
    }
    return 0;
}

}    // namespace

// Under strace, which slows it down: the flood fills its batches.
void measure_calls(Run& run) {
    const std::string what = "System calls a frame, UDP to UDP unpacked under load, by strace";
    if (std::system("strace -V >/dev/null 2>&1") != 0) return run.table.skip(what, "strace is not installed");
    const std::string path = "/tmp/anogate-bench-calls-" + std::to_string(::getpid());
    std::vector<double> calls_a_frame;
    for (int round = 0; round < 3; ++round) {
        double frames = 0;
        {
            const Forwarder forwarder = anogated_from_udp(run.anogated, 1, unpacked,
                                                          {"strace", "-D", "-f", "-c", "-U", "calls,name", "-o", path});
            const Sink sink{forwarder.taken_at()};
            {
                const Flood flood{forwarder.port, target};
                std::this_thread::sleep_for(1s);
            }
            frames = static_cast<double>(forwarder.frames());
        }
        const double calls = traced_calls(path);
        std::filesystem::remove(path);
        if (calls == 0) return run.table.skip(what, "strace may not trace here");
        calls_a_frame.push_back(calls / frames);
    }
    run.table.measure(what, calls_a_frame, at_most(0.2));
}

}    // namespace bench
