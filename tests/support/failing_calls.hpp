// Replaces the system calls by which frames leave, so that a test can make them do what a kernel may do but seldom does. Include it in one file of a program.
#pragma once
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace support {

/// What happens to one call: an errno, or so many bytes (writev) or datagrams (sendmmsg) are taken at most, and no datagram of more
/// bytes than the way carries.
struct Fate {
    int error = 0;
    std::size_t most = SIZE_MAX;
    std::size_t mtu = SIZE_MAX;
};

/// Asked before every call; calls that are not of the gateway's links (the file descriptor tells) get {}.
inline std::function<Fate(int fd)> fate_of_writev, fate_of_sendmmsg;

}    // namespace support

extern "C" {

ssize_t writev(int fd, const iovec* pieces, int count) {
    const support::Fate fate = support::fate_of_writev ? support::fate_of_writev(fd) : support::Fate{};
    if (fate.error != 0) {
        errno = fate.error;
        return -1;
    }
    std::vector<iovec> some(pieces, pieces + count);
    std::size_t room = fate.most;
    for (iovec& piece : some) {
        piece.iov_len = std::min(piece.iov_len, room);
        room -= piece.iov_len;
    }
    return ::syscall(SYS_writev, fd, some.data(), count);
}

int sendmmsg(int fd, mmsghdr* messages, unsigned count, int flags) {
    const support::Fate fate = support::fate_of_sendmmsg ? support::fate_of_sendmmsg(fd) : support::Fate{};
    if (fate.error != 0) {
        errno = fate.error;
        return -1;
    }
    count = static_cast<unsigned>(std::min<std::size_t>(count, fate.most));
    const auto passes = [&](const mmsghdr& message) {
        std::size_t bytes = 0;
        for (std::size_t i = 0; i < message.msg_hdr.msg_iovlen; ++i) bytes += message.msg_hdr.msg_iov[i].iov_len;
        return bytes <= fate.mtu;
    };
    const unsigned offered = count;
    count = static_cast<unsigned>(std::find_if_not(messages, messages + count, passes) - messages);
    if (count == 0 && offered > 0) {
        errno = EMSGSIZE;
        return -1;
    }
    return static_cast<int>(::syscall(SYS_sendmmsg, fd, messages, count, flags));
}

}    // extern "C"
