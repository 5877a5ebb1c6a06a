#include <sys/notify.hpp>

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>

namespace notify_tests {
namespace {

using namespace std::chrono_literals;
using anogate::watchdog_interval;

class Watchdog : public testing::Test {
protected:
    void TearDown() override {
        ::unsetenv("WATCHDOG_USEC");
        ::unsetenv("WATCHDOG_PID");
    }
    static void set(const std::string& interval, const std::string& pid) {
        ::setenv("WATCHDOG_USEC", interval.c_str(), 1);
        ::setenv("WATCHDOG_PID", pid.c_str(), 1);
    }
};

TEST_F(Watchdog, is_notified_twice_per_interval) {
    ::setenv("WATCHDOG_USEC", "3000000", 1);
    EXPECT_EQ(watchdog_interval(), 1500ms) << "for every process";
    set("3000000", std::to_string(::getpid()));
    EXPECT_EQ(watchdog_interval(), 1500ms) << "for this one";
}

// The process that starts us may have been started by systemd, and left its variables.
TEST_F(Watchdog, of_another_process_is_not_notified) {
    set("3000000", std::to_string(::getppid()));
    EXPECT_EQ(watchdog_interval(), std::nullopt);
    set("3000000", "");
    EXPECT_EQ(watchdog_interval(), std::nullopt);
}

TEST_F(Watchdog, is_off_without_an_interval) {
    EXPECT_EQ(watchdog_interval(), std::nullopt);
    for (const char* none : {"0", "-1", ""}) {
        set(none, std::to_string(::getpid()));
        EXPECT_EQ(watchdog_interval(), std::nullopt) << none;
    }
}

}    // namespace
}    // namespace notify_tests
