// Requests to a disk that may hang.
#include <http/task_pool.hpp>
#include <support/loop.hpp>

#include <gtest/gtest.h>

#include <unistd.h>

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace disk_works_tests {
namespace {

using anogate::TaskPool;
using support::Loop;

/// Reads hang until they are released.
class HangingDisk {
public:
    HangingDisk() { EXPECT_EQ(::pipe(pipe_.data()), 0); }
    ~HangingDisk() {
        ::close(pipe_[1]);
        ::close(pipe_[0]);
    }
    std::function<void()> read() const {
        return [fd = pipe_[0]] {
            char byte = 0;
            (void)!::read(fd, &byte, 1);
        };
    }
    void let_go(std::size_t count) {
        EXPECT_EQ(::write(pipe_[1], std::string(count, 'x').data(), count), static_cast<ssize_t>(count));
    }

private:
    std::array<int, 2> pipe_{};
};

TEST(TaskPool, are_all_done_even_if_there_are_more_than_threads) {
    Loop loop;
    TaskPool disk{loop.io};
    int done = 0;
    std::vector<TaskPool::Ticket> tickets;
    for (int i = 0; i < 50; ++i)
        tickets.push_back(disk.run([] {}, [&](const std::string& fault) { done += fault.empty() ? 1 : 0; }));
    EXPECT_EQ(done, 0) << "never at once";
    EXPECT_TRUE(loop.until([&] { return done == 50; }));
    disk.run_detached([] {}, [&](const std::string&) { ++done; });
    EXPECT_TRUE(loop.until([&] { return done == 51; }));
}

TEST(TaskPool, that_hang_delay_others_only_if_no_thread_is_free) {
    Loop loop;
    HangingDisk hanging;
    TaskPool disk{loop.io};
    int hung = 0, done = 0;
    std::vector<TaskPool::Ticket> tickets;
    for (int i = 0; i < 3; ++i) tickets.push_back(disk.run(hanging.read(), [&](const std::string&) { ++hung; }));
    const auto fourth = disk.run([] {}, [&](const std::string&) { ++done; });
    EXPECT_TRUE(loop.until([&] { return done == 1; }));
    EXPECT_EQ(hung, 0);
    hanging.let_go(3);
    EXPECT_TRUE(loop.until([&] { return hung == 3; }));
}

TEST(TaskPool, that_were_cancelled_are_not_reported_and_not_started) {
    Loop loop;
    HangingDisk hanging;
    TaskPool disk{loop.io};
    const auto begun = std::make_shared<std::atomic<bool>>(false);
    bool told = false;
    std::vector<TaskPool::Ticket> tickets;
    for (int i = 0; i < 4; ++i) tickets.push_back(disk.run(hanging.read(), [&](const std::string&) { told = true; }));
    auto waiting = disk.run([begun] { *begun = true; }, [&](const std::string&) { told = true; });
    waiting.reset();
    tickets.clear();
    hanging.let_go(4);
    bool last = false;
    const auto after = disk.run([] {}, [&](const std::string&) { last = true; });
    EXPECT_TRUE(loop.until([&] { return last; }));
    EXPECT_FALSE(*begun);
    EXPECT_FALSE(told);
}

TEST(TaskPool, are_abandoned_at_the_end) {
    Loop loop;
    auto hanging = std::make_unique<HangingDisk>();
    bool told = false;
    {
        TaskPool disk{loop.io};
        disk.run_detached(hanging->read(), [&](const std::string&) { told = true; });
        disk.stop();
        disk.run_detached([] {}, [&](const std::string&) { told = true; });
    }
    hanging->let_go(1);
    EXPECT_FALSE(loop.until([&] { return told; }, std::chrono::milliseconds{50}));
}

}    // namespace
}    // namespace disk_works_tests
