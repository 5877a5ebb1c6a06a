// How slow a slow disk is: a file that both its program and a test have in memory.
#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <string>

namespace support {

/// All zero: as fast as the disk below.
struct DiskSpeed {
    std::atomic<bool> is_mounted{false};
    std::atomic<std::int64_t> ns_a_byte{0}, ns_a_write{0};    // that a write takes; one that is under way heeds a change
    std::atomic<std::int64_t> slow_since{0};                  // when the first slow write came: Unix time, ns; 0: none did
    std::atomic<int> waiting{0};                              // slow writes that are under way
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "two processes share them");

/// The one in a file, which is made when it is missing and stays mapped until the process ends.
inline DiskSpeed& shared_disk_speed(const std::string& path) {
    const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (fd < 0 || ::ftruncate(fd, sizeof(DiskSpeed)) != 0) std::abort();
    void* at = ::mmap(nullptr, sizeof(DiskSpeed), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (at == MAP_FAILED) std::abort();
    ::close(fd);
    return *static_cast<DiskSpeed*>(at);
}

}    // namespace support
