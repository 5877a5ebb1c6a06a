#include <http/listeners/local_socket.hpp>
#include <sys/errors.hpp>
#include <sys/files/own_folder.hpp>

#include <fcntl.h>
#include <grp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <filesystem>

namespace anogate::http {
namespace {

constexpr int backlog = SOMAXCONN;    // clients that wait for a place in the kernel
constexpr char another_path[] = " (use --control with another path, or --control none)";
constexpr char in_use[] = ": another program is using it (use --control with another path)";

sockaddr_un address_of(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    return address;
}

// A path of the file that `held` refers to, even if it was moved.
std::string path_of(const UniqueFd& held) { return "/proc/self/fd/" + std::to_string(held.get()); }

// Connects to the socket file that `held` refers to; on failure see errno.
UniqueFd connect_to(const UniqueFd& held) {
    UniqueFd fd{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
    const sockaddr_un address = address_of(path_of(held));
    if (fd && ::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        const int error = errno;
        fd = UniqueFd{};
        errno = error;
    }
    return fd;
}

// Only ECONNREFUSED means that nothing listens there. After any other error (other socket type, no permission, no more
// descriptors) the file must not be replaced.
bool is_alive(const UniqueFd& held) { return connect_to(held) || errno != ECONNREFUSED; }

// Queries the process that listens from the kernel: another user may have replaced the file in a folder of theirs.
bool is_our_own(const UniqueFd& held) {
    const UniqueFd fd = connect_to(held);
    ucred who{};
    socklen_t size = sizeof who;
    return fd && ::getsockopt(fd.get(), SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 && who.pid == ::getpid();
}

bool is_same(const struct stat& one, const struct stat& other) {
    return one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

// In a private folder such as $XDG_RUNTIME_DIR no other user is meant to have access.
bool is_private(const std::filesystem::path& folder) {
    struct stat info {};
    return ::stat(folder.c_str(), &info) == 0 && (info.st_mode & 0011) == 0;
}

LocalSocket::Outcome failed(std::string error, bool used = false) { return {std::move(error), used, {}, {}}; }

UniqueFd look_at(const HeldFolder& folder, const std::string& name, struct stat& info) {
    UniqueFd there{::openat(folder.fd(), name.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC)};
    if (there && ::fstat(there.get(), &info) != 0) return {};
    return there;
}

}    // namespace

LocalSocket::Outcome LocalSocket::listen(const std::string& path) {
    if (path.size() >= sizeof sockaddr_un{}.sun_path)
        return failed(path + ": the path of a socket has at most " + std::to_string(sizeof sockaddr_un{}.sun_path - 1) +
                      " bytes");
    UniqueFd socket{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
    if (!socket) return failed(error_text(path, errno));
    if (auto folder = make_folder_of(path); !folder) return failed(std::move(folder.error()));
    if (const auto taken = lock_.acquire(path); !taken)
        return failed(taken.error().in_use ? path + in_use : taken.error().why + another_path, taken.error().in_use);
    Outcome outcome = make_room(path);
    if (outcome.error.empty()) outcome = make(socket.get(), path);
    if (!outcome.error.empty()) {
        lock_.release();
        return outcome;
    }
    const group* group = ::getgrnam("anogate");
    if ((!group || !let_in(group->gr_gid)) && !is_private(folder_of(path)))
        outcome.notice = path + ": accessible to this user only (not a member of group anogate)";
    outcome.fd = std::move(socket);
    return outcome;
}

// Removes a socket left by a dead process of our user, or of any user in a folder of ours.
LocalSocket::Outcome LocalSocket::make_room(const std::string& path) {
    auto folder = HeldFolder::of(folder_of(path));
    name_ = std::filesystem::path{path}.filename().string();
    if (!folder) return failed(path + ": " + folder.error() + another_path);
    folder_ = std::move(*folder);
    struct stat info {
    }, around{};
    const UniqueFd there = look_at(folder_, name_, info);
    if (!there) return {};
    if (!S_ISSOCK(info.st_mode)) return failed(path + ": exists and is not a socket (use --control with another path)");
    if (is_alive(there)) return failed(path + in_use, true);
    const bool in_our_folder = ::fstat(folder_.fd(), &around) == 0 && around.st_uid == ::geteuid();
    if (info.st_uid != ::geteuid() && !in_our_folder)
        return failed(path + ": is a socket of another user and is left alone (use --control with another path)");
    ::unlinkat(folder_.fd(), name_.c_str(), 0);
    return {};
}

LocalSocket::Outcome LocalSocket::make(int socket, const std::string& path) {
    // bind() gives the file the mode of the socket: no other user can connect before let_in(). The umask would affect all threads.
    const sockaddr_un address = address_of(folder_.is_fixed() ? path : folder_.at(name_));
    if (::fchmod(socket, 0600) != 0 || ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(socket, backlog) != 0)
        return failed(error_text(path, errno) + another_path, errno == EADDRINUSE);
    struct stat info {};
    made_ = look_at(folder_, name_, info);
    if (made_ && S_ISSOCK(info.st_mode) && is_our_own(made_)) return {};
    made_ = UniqueFd{};
    return failed(path + ": the socket disappeared: another program changes this folder" + another_path);
}

// False: we are not a member of the group, or may not change the file.
bool LocalSocket::let_in(gid_t group) {
    const bool given = ::fchownat(made_.get(), "", uid_t(-1), group, AT_EMPTY_PATH) == 0;
    return given && ::chmod(path_of(made_).c_str(), 0660) == 0;
}

void LocalSocket::remove() noexcept {
    struct stat ours {
    }, there{};
    if (made_ && ::fstat(made_.get(), &ours) == 0 && ::fstatat(folder_.fd(), name_.c_str(), &there, AT_SYMLINK_NOFOLLOW) == 0 &&
        is_same(ours, there))
        ::unlinkat(folder_.fd(), name_.c_str(), 0);
    made_ = UniqueFd{};
    lock_.release();
}

}    // namespace anogate::http
