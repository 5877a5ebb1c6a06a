// A private disk of the test: a tmpfs in its own mount namespace, which ends with the process.
#pragma once
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace support {

class SmallDisk {
public:
    /// Mounted at `folder`, which must exist. Threads that are started later see it.
    SmallDisk(std::string folder, const std::string& size) : folder_{std::move(folder)} {
        if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
            ::mount("tmpfs", folder_.c_str(), "tmpfs", 0, ("size=" + size).c_str()) != 0)
            why_not_ = std::string{"no disk of its own here: "} + std::strerror(errno);
    }
    ~SmallDisk() {
        if (why_not_.empty()) ::umount2(folder_.c_str(), MNT_DETACH);
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;

    /// The reason why the disk is not mounted; empty: it is mounted.
    const std::string& why_not() const { return why_not_; }
    /// Makes the disk read-only, or writable again. False: nothing changed, for example because a file is open for writing.
    bool read_only(bool yes) const { return ::mount("", folder_.c_str(), "", MS_REMOUNT | (yes ? MS_RDONLY : 0), "") == 0; }

private:
    std::string folder_;
    std::string why_not_;
};

}    // namespace support
