// A lock on a path, so that only one gateway creates a file there. The kernel releases it when the process ends for any reason.
#pragma once
#include <sys/unique_fd.hpp>

#include <filesystem>
#include <string>

#include <tl/expected.hpp>

namespace anogate {

/// The lock file is in a folder where no other user can create one: in /run/anogate for root and the service, in
/// $XDG_RUNTIME_DIR/anogate for a user. Without either it is next to the path; if another user has created a file there, the path
/// is used without a lock, so that the other user can't block it. The folder is identified by its inode, because a path may be
/// written in several ways.
class PathLock {
public:
    PathLock() = default;
    PathLock(const PathLock&) = delete;
    PathLock& operator=(const PathLock&) = delete;
    ~PathLock() { release(); }

    struct Refusal {
        std::string why;
        bool in_use = false;    // by another gateway, or another link of this gateway
    };
    /// Does not block. The folder of `path` must exist. Taking the same path again keeps the lock.
    tl::expected<void, Refusal> acquire(const std::filesystem::path& path);
    void release() noexcept;

private:
    enum class Lock { ours, in_use, impossible };
    Lock lock(bool trusted);

    UniqueFd folder_;     // of the lock file
    std::string name_;    // of the lock file
    UniqueFd lock_;
};

}    // namespace anogate
