// A file system by FUSE over a folder, whose writes take as long as a test says.
//     slow_disk SPEED FOLDER MOUNT_POINT    SPEED: a file with a DiskSpeed; it runs until it is unmounted or ended
#define FUSE_USE_VERSION 31
#include "disk_speed.hpp"

#include <fuse.h>

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <thread>

namespace {

using namespace std::chrono_literals;

support::DiskSpeed* speed = nullptr;
int folder = -1;

int result_of(int returned) { return returned < 0 ? -errno : 0; }

// Of a path in the file system, the one below the folder.
const char* below(const char* path) { return path[1] == '\0' ? "." : path + 1; }

int fd_of(const fuse_file_info* file) { return static_cast<int>(file->fh); }

int opened(int fd, fuse_file_info* file) {
    if (fd < 0) return -errno;
    file->fh = static_cast<std::uint64_t>(fd);
    return 0;
}

void take_time(std::size_t bytes) {
    const auto left = [&, begun = std::chrono::steady_clock::now()] {
        const std::int64_t time = speed->ns_a_write + static_cast<std::int64_t>(bytes) * speed->ns_a_byte;
        return std::chrono::nanoseconds{time} - (std::chrono::steady_clock::now() - begun);
    };
    if (left() <= 0ns) return;
    std::int64_t never = 0;
    speed->slow_since.compare_exchange_strong(
        never, std::chrono::nanoseconds{std::chrono::system_clock::now().time_since_epoch()}.count());
    ++speed->waiting;
    for (auto time = left(); time > 0ns; time = left())
        std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(time, 5ms));
    --speed->waiting;
}

void* begin(fuse_conn_info*, fuse_config*) {
    speed->is_mounted = true;
    return nullptr;
}

int get_attributes(const char* path, struct stat* result, fuse_file_info* file) {
    return result_of(file != nullptr ? ::fstat(fd_of(file), result)
                                     : ::fstatat(folder, below(path), result, AT_SYMLINK_NOFOLLOW));
}

int make_folder(const char* path, mode_t mode) { return result_of(::mkdirat(folder, below(path), mode)); }
int remove_file(const char* path) { return result_of(::unlinkat(folder, below(path), 0)); }
int remove_folder(const char* path) { return result_of(::unlinkat(folder, below(path), AT_REMOVEDIR)); }
int change_mode(const char* path, mode_t mode, fuse_file_info*) { return result_of(::fchmodat(folder, below(path), mode, 0)); }

int rename_file(const char* from, const char* to, unsigned flags) {
    return flags != 0 ? -EINVAL : result_of(::renameat(folder, below(from), folder, below(to)));
}

int truncate_file(const char* path, off_t size, fuse_file_info* file) {
    if (file != nullptr) return result_of(::ftruncate(fd_of(file), size));
    const int fd = ::openat(folder, below(path), O_WRONLY | O_CLOEXEC);
    if (fd < 0) return -errno;
    const int result = result_of(::ftruncate(fd, size));
    ::close(fd);
    return result;
}

int open_file(const char* path, fuse_file_info* file) {
    return opened(::openat(folder, below(path), (file->flags & ~O_APPEND) | O_CLOEXEC), file);
}
int create_file(const char* path, mode_t mode, fuse_file_info* file) {
    return opened(::openat(folder, below(path), (file->flags & ~O_APPEND) | O_CREAT | O_CLOEXEC, mode), file);
}
int close_file(const char*, fuse_file_info* file) { return result_of(::close(fd_of(file))); }

int read_file(const char*, char* bytes, std::size_t size, off_t at, fuse_file_info* file) {
    const ssize_t count = ::pread(fd_of(file), bytes, size, at);
    return count < 0 ? -errno : static_cast<int>(count);
}

int write_file(const char*, const char* bytes, std::size_t size, off_t at, fuse_file_info* file) {
    take_time(size);
    const ssize_t count = ::pwrite(fd_of(file), bytes, size, at);
    return count < 0 ? -errno : static_cast<int>(count);
}

int sync_file(const char*, int data_alone, fuse_file_info* file) {
    return result_of(data_alone != 0 ? ::fdatasync(fd_of(file)) : ::fsync(fd_of(file)));
}

int read_folder(const char* path, void* entries, fuse_fill_dir_t add, off_t, fuse_file_info*, fuse_readdir_flags) {
    const int fd = ::openat(folder, below(path), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR* all = fd < 0 ? nullptr : ::fdopendir(fd);
    if (all == nullptr) return -errno;
    while (const dirent* entry = ::readdir(all)) add(entries, entry->d_name, nullptr, 0, fuse_fill_dir_flags{});
    ::closedir(all);
    return 0;
}

int get_room(const char*, struct statvfs* result) { return result_of(::fstatvfs(folder, result)); }

fuse_operations operations() {
    fuse_operations all{};
    all.init = begin;
    all.getattr = get_attributes;
    all.mkdir = make_folder;
    all.unlink = remove_file;
    all.rmdir = remove_folder;
    all.chmod = change_mode;
    all.rename = rename_file;
    all.truncate = truncate_file;
    all.open = open_file;
    all.create = create_file;
    all.release = close_file;
    all.read = read_file;
    all.write = write_file;
    all.fsync = sync_file;
    all.readdir = read_folder;
    all.statfs = get_room;
    return all;
}

}    // namespace

int main(int count, char** arguments) {
    if (count != 4) {
        std::fputs("slow_disk SPEED FOLDER MOUNT_POINT\n", stderr);
        return 2;
    }
    speed = &support::shared_disk_speed(arguments[1]);
    folder = ::open(arguments[2], O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) {
        std::perror(arguments[2]);
        return 1;
    }
    std::string program = arguments[0], in_foreground = "-f", mount_point = arguments[3];
    char* own[] = {program.data(), in_foreground.data(), mount_point.data()};
    const fuse_operations all = operations();
    return fuse_main(3, own, &all, nullptr);
}
