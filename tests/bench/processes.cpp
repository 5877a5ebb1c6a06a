#include "processes.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <string>
#include <thread>

namespace bench {
namespace {

void stay_on(int processor) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<unsigned>(processor), &set);
    if (::sysconf(_SC_NPROCESSORS_ONLN) > processor) ::sched_setaffinity(0, sizeof set, &set);
}

std::uint64_t status_field(pid_t pid, const std::string& name) {
    std::ifstream status{"/proc/" + std::to_string(pid) + "/status"};
    for (std::string word; status >> word;) {
        std::uint64_t value = 0;
        if (word == name && status >> value) return value;
    }
    return 0;
}

}    // namespace

double cpu_seconds(pid_t process) {
    clockid_t clock;
    timespec t{};
    if (::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &t) != 0) return 0;
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::vector<double> percent_of_a_core(pid_t process) {
    using std::chrono::steady_clock;
    std::vector<double> percent;
    for (int second = 0; second < 8; ++second) {
        const double cpu = cpu_seconds(process);
        const auto begin = steady_clock::now();
        std::this_thread::sleep_for(std::chrono::seconds{1});
        const std::chrono::duration<double> wall = steady_clock::now() - begin;
        percent.push_back(100 * (cpu_seconds(process) - cpu) / wall.count());
    }
    return percent;
}

std::uint64_t wake_ups(pid_t process) { return status_field(process, "voluntary_ctxt_switches:"); }
std::uint64_t resident_bytes(pid_t process) { return status_field(process, "VmRSS:") * 1024; }
std::uint64_t max_resident_bytes(pid_t process) { return status_field(process, "VmHWM:") * 1024; }

void stay_on_first_processor() { stay_on(0); }
void stay_on_second_processor() { stay_on(1); }

Undisturbed::Undisturbed() {
    const sched_param lowest{1};
    ::sched_setscheduler(0, SCHED_FIFO, &lowest);
}

Undisturbed::~Undisturbed() {
    const sched_param none{0};
    ::sched_setscheduler(0, SCHED_OTHER, &none);
}

std::uint64_t* shared_word() {
    void* page = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    return static_cast<std::uint64_t*>(page);
}

}    // namespace bench
