#include <sys/notify.hpp>
#include <sys/unique_fd.hpp>

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace anogate {

namespace {

// The longest wait for room in the queue of systemd.
constexpr timeval room_within{0, 200'000};

bool send(std::string_view message, msghdr& header, int flags) noexcept {
    const char* path = std::getenv("NOTIFY_SOCKET");
    sockaddr_un address{};
    if (!path || (path[0] != '/' && path[0] != '@') || std::strlen(path) >= sizeof address.sun_path) return false;
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path);
    if (path[0] == '@') address.sun_path[0] = '\0';
    const UniqueFd fd{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    if (!fd) return false;
    ::setsockopt(fd.get(), SOL_SOCKET, SO_SNDTIMEO, &room_within, sizeof room_within);
    iovec text{const_cast<char*>(message.data()), message.size()};
    header.msg_name = &address;
    header.msg_namelen = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + std::strlen(path));
    header.msg_iov = &text;
    header.msg_iovlen = 1;
    return ::sendmsg(fd.get(), &header, MSG_NOSIGNAL | flags) == static_cast<ssize_t>(message.size());
}

}    // namespace

bool notify_systemd(std::string_view message) noexcept { return notify_systemd(message, {}, Patience::none); }

bool notify_systemd(std::string_view message, std::span<const int> descriptors, Patience patience) noexcept {
    constexpr std::size_t max_descriptors = 253;    // SCM_MAX_FD
    alignas(cmsghdr) std::array<std::uint8_t, CMSG_SPACE(max_descriptors * sizeof(int))> control{};
    msghdr header{};
    if (descriptors.size() > max_descriptors) return false;
    if (!descriptors.empty()) {
        header.msg_control = control.data();
        header.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
        cmsghdr* const passed = CMSG_FIRSTHDR(&header);
        passed->cmsg_level = SOL_SOCKET;
        passed->cmsg_type = SCM_RIGHTS;
        passed->cmsg_len = CMSG_LEN(descriptors.size_bytes());
        std::memcpy(CMSG_DATA(passed), descriptors.data(), descriptors.size_bytes());
    }
    return send(message, header, patience == Patience::none ? MSG_DONTWAIT : 0);
}

std::optional<ano::Duration> watchdog_interval() noexcept {
    const char* interval = std::getenv("WATCHDOG_USEC");
    const char* pid = std::getenv("WATCHDOG_PID");
    if (!interval || (pid && std::atol(pid) != ::getpid())) return std::nullopt;
    const long long microseconds = std::atoll(interval);
    if (microseconds <= 0) return std::nullopt;
    return std::chrono::microseconds{microseconds} / 2;
}

}    // namespace anogate
