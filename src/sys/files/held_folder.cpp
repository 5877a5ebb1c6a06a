#include <sys/errors.hpp>
#include <sys/files/held_folder.hpp>

#include <fcntl.h>
#include <sys/stat.h>

#include <array>

namespace anogate {
namespace {

namespace fs = std::filesystem;

constexpr int max_symlinks = 40;    // the same limit as in the kernel
constexpr int look = O_PATH | O_NOFOLLOW | O_CLOEXEC;

bool is_trusted(const struct stat& info) { return info.st_uid == 0 || info.st_uid == ::geteuid(); }

}    // namespace

// False: see errno, or `name` is a symbolic link.
bool HeldFolder::enter(const char* name) {
    UniqueFd next{fd_ ? ::openat(fd_.get(), name, look | O_DIRECTORY) : ::open(name, look | O_DIRECTORY)};
    struct stat info {};
    if (!next || ::fstat(next.get(), &info) != 0) return false;
    const bool only_ours_may_change = (info.st_mode & 0022) == 0 || (info.st_mode & S_ISVTX) != 0;
    fixed_ = fixed_ && is_trusted(info) && only_ours_may_change;
    fd_ = std::move(next);
    return true;
}

Expected<HeldFolder> HeldFolder::of(const fs::path& path) {
    HeldFolder folder;
    fs::path rest = path;
    if (!folder.enter(path.is_absolute() ? "/" : ".")) return Unexpected{error_text(errno)};
    for (int links = 0; !rest.empty();) {
        const fs::path step = *rest.begin();
        fs::path behind;
        for (auto part = std::next(rest.begin()); part != rest.end(); ++part) behind /= *part;
        rest = behind;
        if (step.empty() || step == "/" || step == "." || folder.enter(step.c_str())) continue;
        const int error = errno;
        struct stat info {};
        std::array<char, 4096> target{};
        const UniqueFd link{::openat(folder.fd(), step.c_str(), look)};
        const ssize_t size = link ? ::readlinkat(link.get(), "", target.data(), target.size()) : -1;
        if (size < 0 || ::fstat(link.get(), &info) != 0) return Unexpected{error_text(error)};
        if (!is_trusted(info))
            return Unexpected{"leads through " + step.string() + ", a symbolic link of another user, which is not followed"};
        if (++links > max_symlinks) return Unexpected{error_text(ELOOP)};
        const fs::path leads_to{std::string{target.data(), static_cast<std::size_t>(size)}};
        if (leads_to.is_absolute()) {
            folder.fd_ = UniqueFd{};
            if (!folder.enter("/")) return Unexpected{error_text(errno)};
        }
        rest = leads_to / rest;
    }
    return folder;
}

}    // namespace anogate
