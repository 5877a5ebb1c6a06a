#include "traffic_ends.hpp"

#include <ano/frame.hpp>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace bench {
namespace {

constexpr std::size_t batch = 64;

sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
}

// Memory for a batch of datagrams, in and out.
struct Batch {
    static constexpr std::size_t room = 2048;
    std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(batch * room);
    std::array<iovec, batch> pieces;
    std::array<mmsghdr, batch> messages;
    Batch() {
        for (std::size_t i = 0; i < batch; ++i) {
            messages[i] = {};
            messages[i].msg_hdr.msg_iov = &pieces[i];
            messages[i].msg_hdr.msg_iovlen = 1;
            pieces[i] = {bytes.data() + i * room, room};
        }
    }
    int receive(int fd) {
        for (std::size_t i = 0; i < batch; ++i) pieces[i] = {bytes.data() + i * room, room};
        return ::recvmmsg(fd, messages.data(), batch, MSG_DONTWAIT, nullptr);
    }
};

}    // namespace

void must(bool good, const char* what) {
    if (good) return;
    std::perror(what);
    std::exit(1);
}

std::vector<std::uint8_t> frame(std::uint8_t source, std::uint8_t destination, std::uint64_t number, std::uint8_t id) {
    std::array<std::uint8_t, frame_size - ano::overhead> data{};
    std::memcpy(data.data(), &number, sizeof number);
    std::vector<std::uint8_t> bytes(frame_size);
    ano::encode(bytes, source, destination, id, data);
    return bytes;
}

Socket::Socket() : fd_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {
    const int room = 4 << 20;
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    sockaddr_in address = loopback(0);
    must(::bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0, "bind");
    socklen_t size = sizeof address;
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
}

Socket::~Socket() { ::close(fd_); }

void Socket::connect(std::uint16_t port) {
    const sockaddr_in address = loopback(port);
    must(::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0, "connect");
}

void Socket::send(std::span<const std::uint8_t> bytes) const { must(::send(fd_, bytes.data(), bytes.size(), 0) >= 0, "send"); }

bool Socket::wait_for(std::span<const std::uint8_t> bytes, std::chrono::milliseconds patience) const {
    const auto until = std::chrono::steady_clock::now() + patience;
    std::array<std::uint8_t, 2048> buffer;
    while (std::chrono::steady_clock::now() <= until) {
        const auto size = ::recv(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT);
        if (size >= 0 && std::ranges::equal(bytes, std::span{buffer}.first(static_cast<std::size_t>(size)))) return true;
    }
    return false;
}

Sink::Sink(std::vector<int> fds) : fds_{std::move(fds)} {
    thread_ = std::thread{[this] {
        Batch room;
        while (!stop_) {
            bool some = false;
            for (const int fd : fds_) {
                const int count = room.receive(fd);
                for (int i = 0; i < count; ++i) bytes_ += room.messages[static_cast<std::size_t>(i)].msg_len;
                some |= count == static_cast<int>(batch);
            }
            if (!some) ::usleep(200);
        }
    }};
}

Sink::~Sink() {
    stop_ = true;
    thread_.join();
}

Flood::Flood(std::uint16_t port, std::uint8_t destination) {
    socket_.connect(port);
    thread_ = std::thread{[this, destination] {
        Batch room;
        const std::vector<std::uint8_t> datagram = frame(0x30, destination, 0);
        for (iovec& piece : room.pieces) piece = {const_cast<std::uint8_t*>(datagram.data()), datagram.size()};
        while (!stop_) ::sendmmsg(socket_.fd(), room.messages.data(), batch, 0);
    }};
}

Flood::~Flood() {
    stop_ = true;
    thread_.join();
}

void bare_loop(int in, const std::vector<int>& out, std::size_t pack, std::uint64_t* frames) {
    Batch incoming;
    Batch outgoing;
    pollfd ready{in, POLLIN, 0};
    for (;;) {
        ::poll(&ready, 1, -1);
        const int count = incoming.receive(in);
        if (count <= 0) continue;
        std::uint64_t bytes = 0;
        std::size_t used = 0;
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
            const std::size_t size = incoming.messages[i].msg_len;
            bytes += size;
            if (pack == 0) {
                outgoing.pieces[used++] = {incoming.pieces[i].iov_base, size};
                continue;
            }
            if (used == 0 || outgoing.pieces[used - 1].iov_len + size > pack) {
                outgoing.pieces[used] = {outgoing.bytes.data() + used * Batch::room, 0};
                ++used;
            }
            iovec& last = outgoing.pieces[used - 1];
            std::memcpy(static_cast<std::uint8_t*>(last.iov_base) + last.iov_len, incoming.pieces[i].iov_base, size);
            last.iov_len += size;
        }
        for (const int fd : out) ::sendmmsg(fd, outgoing.messages.data(), static_cast<unsigned>(used), 0);
        *frames += bytes / frame_size;
    }
}

}    // namespace bench
