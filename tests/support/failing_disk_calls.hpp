// Replaces the system calls that write recordings with those of the failing disk. To be included in one file of a program.
#pragma once
#include "failing_disk.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <new>

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
