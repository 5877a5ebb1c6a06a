// Room to receive many datagrams with one system call. One for the whole loop: it is empty again when a read ends.
#pragma once
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>

namespace anogate {

class DatagramBatch {
public:
    static constexpr std::size_t most = 32;
    static constexpr std::size_t room = 65536;    // of each: the largest datagram there is

    DatagramBatch() : bytes_{new std::uint8_t[most * room]} {}    // uninitialised: unused pages cost nothing

    /// Reads what is there, up to `most` datagrams. Returns how many, 0 when there is none, or -1 and errno.
    int receive(int fd) noexcept {
        for (std::size_t i = 0; i < most; ++i) {
            pieces_[i] = {bytes_.get() + i * room, room};
            messages_[i] = {};
            messages_[i].msg_hdr.msg_name = &senders_[i];
            messages_[i].msg_hdr.msg_namelen = sizeof senders_[i];
            messages_[i].msg_hdr.msg_iov = &pieces_[i];
            messages_[i].msg_hdr.msg_iovlen = 1;
        }
        const int count = ::recvmmsg(fd, messages_.data(), most, MSG_DONTWAIT, nullptr);
        return count < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : count;
    }
    std::span<const std::uint8_t> datagram(std::size_t i) const noexcept {
        return {bytes_.get() + i * room, messages_[i].msg_len};
    }
    const sockaddr_storage& sender(std::size_t i) const noexcept { return senders_[i]; }

private:
    std::unique_ptr<std::uint8_t[]> bytes_;
    std::array<mmsghdr, most> messages_;
    std::array<iovec, most> pieces_;
    std::array<sockaddr_storage, most> senders_;
};

}  // namespace anogate
