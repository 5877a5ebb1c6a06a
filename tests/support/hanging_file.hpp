// Replaces read(), so that reads of one file return the bytes that the test writes into a pipe, when it writes them: this
// simulates a very slow disk. To be included in one file of a program.
#pragma once
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <mutex>
#include <string>
#include <string_view>

namespace support {

/// Only one may exist at a time. A read hangs until the pipe contains bytes. When this object is destroyed, reads return the end
/// of the file.
class HangingFile {
public:
    /// `path` must be an existing file.
    explicit HangingFile(const std::string& path) {
        std::array<int, 2> ends{-1, -1};
        struct stat is {};
        if (::stat(path.c_str(), &is) != 0 || ::pipe2(ends.data(), O_CLOEXEC) != 0) return;
        to_ = anogate::UniqueFd{ends[1]};
        const std::lock_guard lock{mutex_};
        from_ = anogate::UniqueFd{ends[0]};
        device_ = is.st_dev;
        inode_ = is.st_ino;
    }
    ~HangingFile() {
        const std::lock_guard lock{mutex_};
        from_ = {};
    }
    HangingFile(const HangingFile&) = delete;
    HangingFile& operator=(const HangingFile&) = delete;

    /// At most 4096 bytes, which the pipe accepts at once.
    bool write_part(std::string_view bytes) const {
        return ::write(to_.get(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
    }
    /// Number of calls that wait for bytes.
    static int readers() { return readers_; }

    static ssize_t read(int fd, void* to, std::size_t size) {
        const anogate::UniqueFd pipe = pipe_of(fd);
        if (!pipe) return ::syscall(SYS_read, fd, to, size);
        ++readers_;
        const ssize_t n = ::syscall(SYS_read, pipe.get(), to, size);
        --readers_;
        return n;
    }

private:
    static anogate::UniqueFd pipe_of(int fd) {
        const std::lock_guard lock{mutex_};
        struct stat is {};
        if (!from_ || ::fstat(fd, &is) != 0 || is.st_dev != device_ || is.st_ino != inode_) return {};
        return anogate::UniqueFd{::fcntl(from_.get(), F_DUPFD_CLOEXEC, 0)};
    }

    static inline std::mutex mutex_;
    static inline anogate::UniqueFd from_;
    static inline dev_t device_{};
    static inline ino_t inode_{};
    static inline std::atomic<int> readers_{0};
    anogate::UniqueFd to_;
};

}    // namespace support

extern "C" ssize_t read(int fd, void* to, size_t size) { return support::HangingFile::read(fd, to, size); }
