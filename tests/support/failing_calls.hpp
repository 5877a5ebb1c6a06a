// Replaces the system calls that send frames, so that a test can simulate results that are rare with a real kernel. To be
// included in one file of a program.
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

/// The result of one call: an errno, or the maximum number of bytes (writev) or datagrams (sendmmsg) that are accepted, and the
/// maximum size of a datagram in bytes.
struct Fate {
    int error = 0;
    std::size_t most = SIZE_MAX;
    std::size_t mtu = SIZE_MAX;
};

/// Called before every call; must return {} for calls that are not of the gateway's links (recognized by the file descriptor).
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
