#include "processes.hpp"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

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

pid_t fork_bound() {
    const pid_t parent = ::getpid();
    const pid_t pid = ::fork();
    if (pid != 0) return pid;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
    stay_on(1);
    return 0;
}

}    // namespace

Child Child::of(const std::function<void()>& body) {
    const pid_t pid = fork_bound();
    if (pid != 0) return Child{pid};
    body();
    ::_exit(0);
}

Child Child::of(const std::vector<std::string>& command, const std::string& log) {
    const pid_t pid = fork_bound();
    if (pid != 0) return Child{pid};
    const int fd = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    ::dup2(fd, STDOUT_FILENO);
    ::dup2(fd, STDERR_FILENO);
    std::vector<char*> words;
    for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    ::execvp(words[0], words.data());
    ::_exit(127);
}

Child::~Child() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
}

int Child::wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

double Child::cpu_seconds() const {
    clockid_t clock;
    timespec t{};
    if (::clock_getcpuclockid(pid_, &clock) != 0 || ::clock_gettime(clock, &t) != 0) return 0;
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::uint64_t Child::wake_ups() const { return status_field(pid_, "voluntary_ctxt_switches:"); }
std::uint64_t Child::resident_bytes() const { return status_field(pid_, "VmRSS:") * 1024; }

std::uint64_t Child::max_resident_bytes() const { return status_field(pid_, "VmHWM:") * 1024; }

void stay_on_first_processor() { stay_on(0); }

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
