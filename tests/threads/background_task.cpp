// Work that may block, in its own thread.
#include <support/loop.hpp>
#include <sys/background_task.hpp>

#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <csignal>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

namespace errand_tests {
namespace {

using anogate::BackgroundTask;
using support::Loop;

TEST(BackgroundTask, runs_in_another_thread_and_reports_its_end_in_the_calling_one) {
    Loop loop;
    BackgroundTask worker{loop.io};
    const auto made = std::make_shared<std::thread::id>();
    int done = 0;
    for (int i = 1; i <= 3; ++i) {
        ASSERT_TRUE(worker.run([made] { *made = std::this_thread::get_id(); },
                               [&](const std::string& fault) {
                                   EXPECT_EQ(fault, "");
                                   EXPECT_FALSE(worker.is_running());
                                   ++done;
                               }));
        EXPECT_TRUE(worker.is_running());
        ASSERT_TRUE(loop.until([&] { return done == i; }));
        EXPECT_NE(*made, std::thread::id{});
        EXPECT_NE(*made, std::this_thread::get_id());
    }
}

TEST(BackgroundTask, does_not_receive_signals_of_the_program) {
    Loop loop;
    BackgroundTask worker{loop.io};
    const auto its_mask = std::make_shared<sigset_t>();
    bool done = false;
    ASSERT_TRUE(worker.run([its_mask] { ::pthread_sigmask(SIG_SETMASK, nullptr, its_mask.get()); },
                           [&](const std::string&) { done = true; }));
    ASSERT_TRUE(loop.until([&] { return done; }));
    for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGTTOU})
        EXPECT_EQ(::sigismember(its_mask.get(), signal), 1) << signal;
}

TEST(BackgroundTask, can_start_the_next_one_and_reports_exceptions) {
    Loop loop;
    BackgroundTask worker{loop.io};
    std::string said;
    ASSERT_TRUE(worker.run([] { throw std::runtime_error{"no disk"}; },
                           [&](const std::string& fault) {
                               said = fault;
                               worker.run([] {}, [&](const std::string& none) { said += "," + none + "done"; });
                           }));
    EXPECT_TRUE(loop.until([&] { return said == "no disk,done"; })) << said;
}

TEST(BackgroundTask, that_is_stopped_reports_nothing_and_one_that_hangs_is_abandoned) {
    Loop loop;
    bool called = false;
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const auto read = [fd = pipe[0]] {
        char byte;
        (void)!::read(fd, &byte, 1);
    };
    {
        BackgroundTask worker{loop.io};
        ASSERT_TRUE(worker.run([] {}, [&](const std::string&) { called = true; }));
        worker.stop();
        loop.turn();
        ASSERT_TRUE(worker.run(read, [&](const std::string&) { called = true; }));
    }
    loop.turn();
    EXPECT_FALSE(called);
    ASSERT_EQ(::write(pipe[1], "x", 1), 1);
    EXPECT_FALSE(loop.until([&] { return called; }, std::chrono::milliseconds{50}));
    ::close(pipe[0]);
    ::close(pipe[1]);
}

}    // namespace
}    // namespace errand_tests
