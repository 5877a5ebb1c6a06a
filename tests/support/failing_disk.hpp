// Replaces the system calls by which a recording gets onto its disk, so that a test can make them do what a disk may do but seldom
// does. Include it in one file of a program.
#pragma once
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <new>
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

extern "C" {

ssize_t pwrite(int fd, const void* bytes, size_t size, off_t at) {
    support::failing_disk.wait();
    if (support::failing_disk.lacks_memory) throw std::bad_alloc{};
    if (const int error = support::failing_disk.write_error; error != 0) {
        const long room = support::failing_disk.room;
        if (room <= 0) {
            errno = error;
            return -1;
        }
        size = size < static_cast<size_t>(room) ? size : static_cast<size_t>(room);
        support::failing_disk.room = room - static_cast<long>(size);
    }
    return ::syscall(SYS_pwrite64, fd, bytes, size, at);
}

int fdatasync(int fd) {
    support::failing_disk.wait();
    if (const int error = support::failing_disk.sync_error; error != 0) {
        errno = error;
        return -1;
    }
    return static_cast<int>(::syscall(SYS_fdatasync, fd));
}

}    // extern "C"
