// A slow disk at the path of a folder: a FUSE file system whose writes take a time that the test sets. It is mounted in a private
// mount namespace of the test, so that it disappears when the test ends in any way.
#pragma once
#include "process.hpp"
#include "temp_dir.hpp"
#include "wait.hpp"

#include <slow_disk/disk_speed.hpp>

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

namespace support {

class SlowDisk {
public:
    /// `program`: tests/slow_disk; empty: it was not built. Mounts the disk at `folder`, which is created. Only processes that
    /// are started later see it.
    SlowDisk(const std::string& program, std::string folder) : folder_{std::move(folder)} {
        if (program.empty()) {
            why_not_ = "built without FUSE's library (libfuse3-dev)";
            return;
        }
        const int fuse = ::open("/dev/fuse", O_RDWR | O_CLOEXEC);
        if (fuse < 0 || ::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0)
            why_not_ = std::string{"no file system by FUSE here: "} + std::strerror(errno);
        if (fuse >= 0) ::close(fuse);
        if (why_not_.empty()) mount(program);
    }
    ~SlowDisk() {
        be_fast();
        if (is_mounted()) ::umount2(folder_.c_str(), MNT_DETACH);
    }
    SlowDisk(const SlowDisk&) = delete;
    SlowDisk& operator=(const SlowDisk&) = delete;

    /// The reason why the disk is not mounted; empty: it is mounted.
    const std::string& why_not() const { return why_not_; }
    void take_a_write_in(std::chrono::nanoseconds time) { speed_.ns_a_write = time.count(); }
    void take_a_second(std::int64_t bytes) { speed_.ns_a_byte = 1'000'000'000 / bytes; }
    void be_fast() { speed_.ns_a_write = speed_.ns_a_byte = 0; }
    bool until_it_is_slow() const {
        return wait_until([&] { return speed_.waiting > 0; });
    }
    /// The time of the first slow write.
    std::chrono::system_clock::time_point slow_since() const {
        return std::chrono::system_clock::time_point{
            std::chrono::duration_cast<std::chrono::system_clock::duration>(std::chrono::nanoseconds{speed_.slow_since})};
    }

private:
    bool is_mounted() const { return speed_.is_mounted; }
    void mount(const std::string& program) {
        std::error_code failed;
        std::filesystem::create_directories(folder_, failed);
        std::filesystem::create_directories(dir_ / "below", failed);
        process_ = std::make_unique<Process>(program, std::vector<std::string>{dir_ / "speed", dir_ / "below", folder_});
        if (!wait_until([&] { return is_mounted() || !process_->is_running(); }) || !is_mounted())
            why_not_ = "no file system by FUSE here: " + process_->output();
    }

    const TempDir dir_;
    std::string folder_;
    std::string why_not_;
    DiskSpeed& speed_ = shared_disk_speed(dir_ / "speed");
    std::unique_ptr<Process> process_;    // ends before its folders are removed
};

}    // namespace support
