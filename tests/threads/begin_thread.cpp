// Threads that leave the signals of the program to the loop.
#include <sys/thread_signals.hpp>

#include <gtest/gtest.h>

#include <pthread.h>

#include <array>
#include <csignal>

namespace begin_thread_tests {
namespace {

constexpr std::array signals{SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGTTOU, SIGPIPE};

sigset_t blocked_here() {
    sigset_t mask;
    ::pthread_sigmask(SIG_SETMASK, nullptr, &mask);
    return mask;
}

TEST(BeginThread, blocks_every_signal_in_the_new_thread_before_it_runs_and_none_in_the_calling_thread) {
    sigset_t before = blocked_here();
    sigset_t inside;
    sigemptyset(&inside);
    anogate::begin_thread([&] { inside = blocked_here(); }).join();
    sigset_t after = blocked_here();
    for (const int signal : signals) {
        EXPECT_EQ(sigismember(&inside, signal), 1) << signal;
        EXPECT_EQ(sigismember(&after, signal), sigismember(&before, signal)) << signal;
    }
}

}    // namespace
}    // namespace begin_thread_tests
