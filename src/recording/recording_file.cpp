#include <record/rotation.hpp>
#include <recording/recording_file.hpp>
#include <sys/error_fault.hpp>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace anogate {
namespace {

constexpr unsigned max_names = 100'000;    // to try
constexpr mode_t folder_mode = 0750, file_mode = 0640;

// Returns 0, or the errno.
int make_folders(const std::filesystem::path& folder) {
    if (::mkdir(folder.c_str(), folder_mode) == 0 || errno == EEXIST) return 0;
    if (errno != ENOENT || !folder.has_parent_path() || folder.parent_path() == folder) return errno;
    if (const int error = make_folders(folder.parent_path()); error != 0) return error;
    return ::mkdir(folder.c_str(), folder_mode) == 0 || errno == EEXIST ? 0 : errno;
}

UniqueFd open_folder(const std::string& folder) { return UniqueFd{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)}; }

}    // namespace

std::variant<RecordingFile, DiskFault> RecordingFile::create(const std::string& folder, const std::string& name,
                                                             RecordingFormat format, unsigned& number) {
    const auto fault = [&](int error) { return DiskFault{error, error_fault(folder, error)}; };
    if (name.empty() || name.find('/') != std::string::npos)
        return DiskFault{EINVAL, {"other", "\"" + name + "\" is not a valid file name"}};
    if (const int error = make_folders(std::filesystem::path{folder}.lexically_normal()); error != 0) return fault(error);
    const UniqueFd at = open_folder(folder);
    if (!at) return fault(errno);
    for (const unsigned last = number + max_names; number < last; ++number) {
        const std::string file = recording_file_name(name, number, format);
        UniqueFd fd{::openat(at.get(), file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, file_mode)};
        if (!fd && errno == EEXIST) continue;
        const std::string path = (std::filesystem::path{folder} / file).string();
        if (!fd) return DiskFault{errno, error_fault(path, errno)};
        ::flock(fd.get(), LOCK_EX | LOCK_NB);    // not every file system supports it
        ::fchmod(fd.get(), file_mode);           // independent of the umask
        ::fsync(at.get());
        return RecordingFile{std::move(fd), path};
    }
    return DiskFault{EEXIST, {"other", folder + ": all names from " + name + " on are in use"}};
}

int RecordingFile::append(std::string_view bytes) {
    std::string_view rest = bytes;
    while (!rest.empty()) {
        const auto at = static_cast<off_t>(size_ + (bytes.size() - rest.size()));
        const ssize_t n = ::pwrite(fd_.get(), rest.data(), rest.size(), at);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            const int error = n < 0 ? errno : EIO;
            if (rest.size() < bytes.size()) cut(size_);
            return error;
        }
        rest.remove_prefix(static_cast<std::size_t>(n));
    }
    size_ += bytes.size();
    return 0;
}

int RecordingFile::sync() {
    if (::fdatasync(fd_.get()) == 0 || errno == EINVAL) return 0;    // EINVAL: not supported by this file
    return errno;
}

void RecordingFile::cut(std::uint64_t size) {
    if (::ftruncate(fd_.get(), static_cast<off_t>(size)) != 0) return;    // readers skip the bytes after it
    size_ = size;
}

bool RecordingFile::is_there() const {
    struct stat ours {
    }, there{};
    return ::fstat(fd_.get(), &ours) == 0 && ::lstat(path_.c_str(), &there) == 0 && ours.st_dev == there.st_dev &&
           ours.st_ino == there.st_ino;
}

void RecordingFile::remove() { ::unlink(path_.c_str()); }

std::optional<std::uint64_t> free_bytes(const std::string& folder) {
    struct statvfs disk {};
    std::filesystem::path path = std::filesystem::path{folder}.lexically_normal();
    while (::statvfs(path.c_str(), &disk) != 0) {
        if (errno != ENOENT || !path.has_parent_path() || path.parent_path() == path) return std::nullopt;
        path = path.parent_path();
    }
    return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

}    // namespace anogate
