// A disk that does what disks may do but seldom do, in a program one of whose files includes failing_disk_calls.hpp.
#pragma once
#include <atomic>
#include <chrono>
#include <thread>

namespace support {

/// What becomes of the calls, from any thread. 0: what the system says.
struct FailingDisk {
    std::atomic<int> write_error{0}, sync_error{0};    // errno
    std::atomic<long> room{-1};                        // bytes that are still taken, before write_error; -1: all
    std::atomic<bool> hangs{false};                    // until it is false again
    std::atomic<int> hanging{0};                       // calls
    std::atomic<bool> lacks_memory{false};             // a write throws std::bad_alloc, as anything may that is on the way to it
    std::atomic<int> slowness{0};                      // milliseconds that each call takes

    void wait() {
        if (const int time = slowness; time > 0) std::this_thread::sleep_for(std::chrono::milliseconds{time});
        if (!hangs) return;
        ++hanging;
        while (hangs) std::this_thread::sleep_for(std::chrono::milliseconds{1});
        --hanging;
    }
};
inline FailingDisk failing_disk;

/// As it is at first, however a test ends.
struct WellAgain {
    ~WellAgain() {
        failing_disk.hangs = failing_disk.lacks_memory = false;
        failing_disk.slowness = 0;
        failing_disk.write_error = failing_disk.sync_error = 0;
        failing_disk.room = -1;
    }
};

}    // namespace support
