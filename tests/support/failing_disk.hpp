// A disk with faults that are rare with real disks, for a program one of whose files includes failing_disk_calls.hpp.
#pragma once
#include <atomic>
#include <chrono>
#include <thread>

namespace support {

/// The results of the calls; may be used from any thread. An errno of 0: the result of the system.
struct FailingDisk {
    std::atomic<int> write_error{0}, sync_error{0};    // errno
    std::atomic<long> room{-1};                        // bytes that are still accepted before write_error; -1: unlimited
    std::atomic<bool> hangs{false};                    // calls hang until it is false again
    std::atomic<int> hanging{0};                       // number of calls that hang
    std::atomic<bool> lacks_memory{false};             // a write throws std::bad_alloc, as any code before it may
    std::atomic<int> slowness{0};                      // duration of each call in milliseconds

    void wait() {
        if (const int time = slowness; time > 0) std::this_thread::sleep_for(std::chrono::milliseconds{time});
        if (!hangs) return;
        ++hanging;
        while (hangs) std::this_thread::sleep_for(std::chrono::milliseconds{1});
        --hanging;
    }
};
inline FailingDisk failing_disk;

/// Resets the disk when a test ends, even if it fails.
struct WellAgain {
    ~WellAgain() {
        failing_disk.hangs = failing_disk.lacks_memory = false;
        failing_disk.slowness = 0;
        failing_disk.write_error = failing_disk.sync_error = 0;
        failing_disk.room = -1;
    }
};

}    // namespace support
