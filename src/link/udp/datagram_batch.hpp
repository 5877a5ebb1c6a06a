// Buffers to receive many datagrams with one system call. One for the whole loop: each read overwrites the content.
#pragma once
#include <ano/lazy_array.hpp>
#include <link/clocks.hpp>

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

namespace anogate {

/// Room for the kernel's timestamp of a message. The socket must have it enabled: keep_stamps().
class Stamp {
public:
    void prepare(msghdr& message) noexcept {
        message.msg_control = room_.data();
        message.msg_controllen = room_.size();
    }
    /// The time (CLOCK_REALTIME) at which the received `message` arrived; std::nullopt: it has no timestamp.
    static std::optional<ano::Duration> of(const msghdr& message) noexcept {
        for (const cmsghdr* c = CMSG_FIRSTHDR(&message); c;
             c = CMSG_NXTHDR(const_cast<msghdr*>(&message), const_cast<cmsghdr*>(c))) {
            if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
            timespec time;
            std::memcpy(&time, CMSG_DATA(c), sizeof time);
            return duration_of(time);
        }
        return std::nullopt;
    }

private:
    alignas(cmsghdr) std::array<std::uint8_t, CMSG_SPACE(sizeof(timespec))> room_;
};

inline ano::TimePoint arrival(const msghdr& message, Arrival& wire, const StallDetector& loop) noexcept {
    const auto stamp = Stamp::of(message);
    return stamp ? wire.stamped(*stamp, loop) : wire.unstamped(loop);
}

inline void keep_stamps(int fd) noexcept {
    const int on = 1;
    ::setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
}

class DatagramBatch {
public:
    static constexpr std::size_t max_datagrams = 32;
    static constexpr std::size_t room = 65536;    // bytes for each: the largest datagram possible

    // Touches the first page of each buffer, so that memory does not grow with the first burst of short datagrams.
    DatagramBatch() : bytes_{max_datagrams * room} {
        for (std::size_t i = 0; i < max_datagrams; ++i) bytes_[i * room] = 0;
    }

    /// Reads the waiting datagrams, up to `max_datagrams`. Returns their number, 0 if there are none, or -1 and errno.
    int receive(int fd) noexcept {
        for (std::size_t i = 0; i < max_datagrams; ++i) {
            pieces_[i] = {bytes_.get() + i * room, room};
            messages_[i] = {};
            messages_[i].msg_hdr.msg_name = &senders_[i];
            messages_[i].msg_hdr.msg_namelen = sizeof senders_[i];
            messages_[i].msg_hdr.msg_iov = &pieces_[i];
            messages_[i].msg_hdr.msg_iovlen = 1;
            stamps_[i].prepare(messages_[i].msg_hdr);
        }
        const int count = ::recvmmsg(fd, messages_.data(), max_datagrams, MSG_DONTWAIT, nullptr);
        return count < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : count;
    }
    std::span<const std::uint8_t> datagram(std::size_t i) const noexcept {
        return {bytes_.get() + i * room, messages_[i].msg_len};
    }
    const sockaddr_storage& sender(std::size_t i) const noexcept { return senders_[i]; }
    /// When datagram `i` arrived.
    ano::TimePoint arrived_at(std::size_t i, Arrival& wire, const StallDetector& loop) const noexcept {
        return arrival(messages_[i].msg_hdr, wire, loop);
    }

private:
    ano::LazyArray<std::uint8_t> bytes_;
    std::array<mmsghdr, max_datagrams> messages_;
    std::array<iovec, max_datagrams> pieces_;
    std::array<sockaddr_storage, max_datagrams> senders_;
    std::array<Stamp, max_datagrams> stamps_;
};

}    // namespace anogate
