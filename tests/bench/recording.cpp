// The cost of recording for a gateway: its loop compared with that of a gateway that does not record, and the thread for the
// disk.
#include "forwarder.hpp"
#include "goals.hpp"
#include "steady.hpp"

#include <support/http.hpp>
#include <support/temp_dir.hpp>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace bench {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr int rounds = 14;
constexpr auto measured = 1s;
constexpr auto settling = 500ms;

/// CPU time of a thread so far, in seconds.
double cpu_of_thread(const fs::path& task) {
    std::uint64_t ns = 0;
    std::ifstream{task / "schedstat"} >> ns;
    return static_cast<double>(ns) * 1e-9;
}

fs::path tasks_of(pid_t process) { return "/proc/" + std::to_string(process) + "/task"; }
fs::path loop_of(pid_t process) { return tasks_of(process) / std::to_string(process); }

/// Empty: not found.
fs::path thread_called(const std::string& name, pid_t process) {
    for (const auto& task : fs::directory_iterator{tasks_of(process)}) {
        std::string its_name;
        std::getline(std::ifstream{task.path() / "comm"}, its_name);
        if (its_name == name) return task.path();
    }
    return {};
}

std::string post(const std::string& control, const std::string& path, const std::string& json) {
    return support::http(control, "POST " + path + " HTTP/1.0\r\nContent-Type: application/json\r\nContent-Length: " +
                                      std::to_string(json.size()) + "\r\n\r\n" + json);
}

/// CPU time of a loop, and frames, so far.
struct Used {
    explicit Used(const Forwarder& of) : frames{of.frames()}, cpu{cpu_of_thread(loop_of(of.pid()))} {}
    std::uint64_t frames;
    double cpu;
};

double microseconds_a_frame(const Used& before, const Used& after) {
    return (after.cpu - before.cpu) * 1e6 / static_cast<double>(after.frames - before.frames);
}

}    // namespace

void measure_recording(Run& run) {
    const support::TempDir state;
    ::setenv("STATE_DIRECTORY", state.path().c_str(), 1);    // the folder of the recordings of the programs started from now on
    const Undisturbed all;                                   // if that is permitted
    const Forwarder recorded = anogated_from_udp(run.anogated, 1, unpacked),
                    beside = anogated_from_udp(run.anogated, 1, unpacked);
    ::unsetenv("STATE_DIRECTORY");
    const Sink sink{{recorded.taken_at().front(), beside.taken_at().front()}};
    const std::string begun = post(recorded.gateway->control(), "/recordings", R"({"name": "bench", "direction": "in"})");
    must(begun.find(" 20") != std::string::npos, "a recording");
    const fs::path writer = thread_called("recorder", recorded.pid());
    must(!writer.empty(), "the thread of the recorder");
    std::vector<double> with, without, of_a_core;
    for (int i = 0; i < rounds; ++i) {
        const Steady traffic{recorded.port, beside.port};
        std::this_thread::sleep_for(settling);
        const Used recorded_before{recorded}, beside_before{beside};
        const double writer_before = cpu_of_thread(writer);
        const auto begin = std::chrono::steady_clock::now();
        std::this_thread::sleep_for(measured);
        const Used recorded_after{recorded}, beside_after{beside};
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
        of_a_core.push_back(100 * (cpu_of_thread(writer) - writer_before) / wall.count());
        with.push_back(microseconds_a_frame(recorded_before, recorded_after));
        without.push_back(microseconds_a_frame(beside_before, beside_after));
    }
    run.table.compare("50,000 frames/s, UDP to UDP, recorded: CPU µs a frame of the loop, beside not recorded", with, without,
                      at_most(1.05));
    run.table.measure("… and % of a core by the thread for the disk", of_a_core, at_most(30));
}

}    // namespace bench
