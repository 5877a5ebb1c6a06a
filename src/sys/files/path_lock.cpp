#include <sys/errors.hpp>
#include <sys/files/held_folder.hpp>
#include <sys/files/own_folder.hpp>
#include <sys/files/path_lock.hpp>

#include <dirent.h>
#include <fcntl.h>
#include <sched.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <string_view>

namespace anogate {
namespace {

constexpr int folder_flags = O_PATH | O_DIRECTORY | O_CLOEXEC;
constexpr int max_tries = 16;          // if others remove the lock file at the same time
constexpr int max_looked_at = 1000;    // lock files in one sweep()
constexpr int lock_flags = O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
constexpr char lock_prefix[] = ".lock-";

// Opens the folder only if no other user can create files there. The owner of /run/anogate was chosen by root.
UniqueFd open_trusted(const std::string& path, mode_t mode, uid_t owner) {
    if (::mkdir(path.c_str(), mode) == 0) ::chmod(path.c_str(), mode);    // independent of the umask
    UniqueFd folder{::open(path.c_str(), folder_flags | O_NOFOLLOW)};
    struct stat info {};
    if (!folder || ::fstat(folder.get(), &info) != 0 || (info.st_mode & 0002) != 0) return {};
    return owner == uid_t(-1) || info.st_uid == owner ? std::move(folder) : UniqueFd{};
}

UniqueFd open_lock_folder() {
    if (::geteuid() == 0 || ::access(runtime_folder, W_OK) == 0)
        if (UniqueFd folder = open_trusted(runtime_folder, 0755, uid_t(-1))) return folder;
    const char* const runtime_dir = std::getenv("XDG_RUNTIME_DIR");
    if (runtime_dir == nullptr || *runtime_dir == '\0' || ::geteuid() == 0) return {};
    return open_trusted(std::string{runtime_dir} + "/anogate", 0700, ::geteuid());
}

std::string lock_name(const struct stat& folder, const std::string& file) {
    return lock_prefix + std::to_string(folder.st_dev) + "-" + std::to_string(folder.st_ino) + "-" +
           std::to_string(std::hash<std::string>{}(file));
}

bool is_same(const struct stat& one, const struct stat& other) {
    return one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

bool is_at(const UniqueFd& folder, const char* name, const struct stat& file) {
    struct stat there {};
    return ::fstatat(folder.get(), name, &there, AT_SYMLINK_NOFOLLOW) == 0 && is_same(file, there);
}

// Only the holder of its lock may remove a lock file. A process that opened the file meanwhile detects that it was removed.
void remove_stale(const UniqueFd& folder, const char* name) {
    const UniqueFd file{::openat(folder.get(), name, lock_flags)};
    struct stat info {};
    if (!file || ::fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode)) return;
    if (::flock(file.get(), LOCK_EX | LOCK_NB) == 0 && is_at(folder, name, info)) ::unlinkat(folder.get(), name, 0);
}

// Removes lock files of gateways that were killed.
void sweep(const UniqueFd& folder) {
    UniqueFd readable{::openat(folder.get(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    const std::unique_ptr<DIR, int (*)(DIR*)> list{readable ? ::fdopendir(readable.get()) : nullptr, ::closedir};
    if (!list) return;
    readable.release();
    int looked_at = 0;
    while (const dirent* const entry = ::readdir(list.get())) {
        if (!std::string_view{entry->d_name}.starts_with(lock_prefix)) continue;
        remove_stale(folder, entry->d_name);
        if (++looked_at == max_looked_at) return;
    }
}

}    // namespace

// The owner removes its file at the end, so a lock is valid only if the file still exists. In a trusted folder the holder may be
// another gateway's sweep(), so locking is retried.
PathLock::Lock PathLock::lock(bool trusted) {
    for (int i = 0; i < max_tries; ++i) {
        lock_ = UniqueFd{::openat(folder_.get(), name_.c_str(), lock_flags | O_CREAT, 0600)};
        struct stat opened {};
        if (!lock_ || ::fstat(lock_.get(), &opened) != 0) return Lock::impossible;
        if (!trusted && (!S_ISREG(opened.st_mode) || opened.st_uid != ::geteuid())) return Lock::impossible;
        if (::flock(lock_.get(), LOCK_EX | LOCK_NB) == 0) {
            if (is_at(folder_, name_.c_str(), opened)) return Lock::ours;
        } else {
            if (errno != EWOULDBLOCK) return Lock::impossible;
            if (!trusted) return Lock::in_use;
            ::sched_yield();
        }
    }
    return Lock::in_use;
}

tl::expected<void, PathLock::Refusal> PathLock::acquire(const std::filesystem::path& path) {
    const auto refused = [](std::string why, bool in_use = false) { return tl::unexpected{Refusal{std::move(why), in_use}}; };
    auto folder = HeldFolder::of(folder_of(path));
    struct stat info {};
    if (!folder) return refused(path.string() + ": " + folder.error());
    if (::fstat(folder->fd(), &info) != 0) return refused(error_text(path.string(), errno));
    const std::string name = lock_name(info, path.filename().string());
    if (lock_ && name == name_) return {};
    release();
    name_ = name;
    folder_ = open_lock_folder();
    const bool trusted = static_cast<bool>(folder_);
    if (!trusted) folder_ = folder->take();
    const Lock result = lock(trusted);
    const int error = errno;
    if (result == Lock::ours && trusted) sweep(folder_);
    if (result == Lock::ours) return {};
    lock_ = UniqueFd{};
    if (result == Lock::in_use) return refused(path.string() + " is in use by another gateway", true);
    if (trusted) return refused(error_text(path.string() + ": can't lock it", error));
    return {};
}

void PathLock::release() noexcept {
    if (lock_) ::unlinkat(folder_.get(), name_.c_str(), 0);
    lock_ = UniqueFd{};
    folder_ = UniqueFd{};
}

}    // namespace anogate
