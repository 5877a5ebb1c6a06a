// SIGTERM at any moment ends the program. ANOGATE_ENDS=10000 sets the number of tries: half of them at random times, half when
// the timer of hints is due, 3 s after the start.
#include <support/random.hpp>
#include <support/temp_dir.hpp>

#include <daemon/program.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

namespace ends_tests {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto patience = 20s;

/// The program in a forked process, without exec. `environment` has the form NAME=VALUE.
pid_t start(const std::string& control, const std::vector<std::string>& environment) {
    const pid_t pid = ::fork();
    if (pid != 0) return pid;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int nowhere = ::open("/dev/null", O_RDWR);
    for (const int fd : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, fd);
    for (const std::string& variable : environment) ::putenv(const_cast<char*>(variable.c_str()));
    std::vector<std::string> words{
        "anogated", "--control", control, "sim:fc,hz=100", "udp-listen:127.0.0.1:0", "serial:/dev/nonexistent"};
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    ::_exit(anogate::run_program(static_cast<int>(argv.size()), argv.data()));
}

/// Whether it ended within `patience` of the signal, either in order, or by the signal before it could handle signals.
bool ends(pid_t pid) {
    const auto limit = Clock::now() + patience;
    int status = 0;
    for (;;) {
        if (::waitpid(pid, &status, WNOHANG) == pid) return status == 0 || (WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
        if (Clock::now() > limit) break;
        std::this_thread::sleep_for(200us);
    }
    ::kill(pid, SIGKILL);
    ::waitpid(pid, &status, 0);
    return false;
}

unsigned asked(unsigned usual) {
    const char* number = std::getenv("ANOGATE_ENDS");
    return number ? static_cast<unsigned>(std::atoi(number)) / 2 : usual;
}

// A watchdog of 50 us is always due: the difficult case is a timer that is due at the moment when it is stopped.
TEST(Ends, whenever_the_signal_arrives) {
    const support::TempDir dir;
    support::Random random{1};
    const unsigned tries = asked(100);
    unsigned lost = 0;
    for (unsigned i = 0; i < tries; ++i) {
        const pid_t pid = start(dir / "control", {"WATCHDOG_USEC=100"});
        std::this_thread::sleep_for(std::chrono::microseconds{random.below(25'000)});
        ::kill(pid, SIGTERM);
        lost += !ends(pid);
    }
    EXPECT_EQ(lost, 0u) << "of " << tries;
}

/// Receives the messages to systemd, which give the time of the start to a tenth of a millisecond.
class Starts {
public:
    explicit Starts(const std::string& path) : fd_{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
    }
    ~Starts() { ::close(fd_); }
    Starts(const Starts&) = delete;
    Starts& operator=(const Starts&) = delete;

    bool wait() const {
        char word[64];
        for (;;) {
            pollfd ready{fd_, POLLIN, 0};
            if (::poll(&ready, 1, 20'000) <= 0) return false;
            const ssize_t size = ::recv(fd_, word, sizeof word, 0);
            if (size >= 5 && std::string(word, 5) == "READY") return true;
        }
    }

private:
    int fd_;
};

TEST(Ends, when_the_hints_are_due) {
    const unsigned tries = asked(0);
    if (tries == 0) GTEST_SKIP() << "takes 3 s each forty: ANOGATE_ENDS=10000";
    const support::TempDir dir;
    const std::string socket = dir / "notify";
    const Starts starts{socket};
    support::Random random{2};
    unsigned lost = 0;
    for (unsigned done = 0; done < tries;) {
        std::vector<std::pair<Clock::time_point, pid_t>> running;
        for (; running.size() < 40 && done < tries; ++done) {
            const pid_t pid = start(dir / ("control" + std::to_string(running.size())), {"NOTIFY_SOCKET=" + socket});
            ASSERT_TRUE(starts.wait());
            running.emplace_back(Clock::now() + 3s + std::chrono::microseconds{random.below(1000)} - 500us, pid);
        }
        for (const auto& [at, pid] : running) {
            std::this_thread::sleep_until(at);
            ::kill(pid, SIGTERM);
        }
        for (const auto& [at, pid] : running) lost += !ends(pid);
    }
    EXPECT_EQ(lost, 0u) << "of " << tries;
}

}    // namespace
}    // namespace ends_tests
