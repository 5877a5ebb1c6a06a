// A program that speaks V8 over UDP to a gateway: the test's own end of it.
#pragma once
#include <ano/parser.hpp>
#include <support/bytes.hpp>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <vector>

namespace support {

class UdpApp {
public:
    UdpApp() : fd_{::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)} {
        sockaddr_in local = loopback(0);
        ::bind(fd_, reinterpret_cast<const sockaddr*>(&local), sizeof local);
        socklen_t size = sizeof local;
        ::getsockname(fd_, reinterpret_cast<sockaddr*>(&local), &size);
        port_ = ntohs(local.sin_port);
        const int room = 4 << 20;
        if (::setsockopt(fd_, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room) != 0)
            ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    }
    UdpApp(const UdpApp&) = delete;
    UdpApp& operator=(const UdpApp&) = delete;
    ~UdpApp() { ::close(fd_); }

    std::uint16_t port() const { return port_; }
    /// A LINK text for a gateway that is to talk to this app.
    std::string link(const std::string& name) const {
        return "udp:127.0.0.1:" + std::to_string(port_) + ",bind=127.0.0.1:0,name=" + name;
    }
    void send(const Bytes& frame, std::uint16_t to) {
        const sockaddr_in there = loopback(to);
        while (::sendto(fd_, frame.data(), frame.size(), 0, reinterpret_cast<const sockaddr*>(&there), sizeof there) < 0 &&
               errno == EAGAIN) {}
    }
    /// The frames that have come since the last call.
    std::vector<Bytes> frames() {
        std::vector<Bytes> all;
        for (;;) {
            const auto room = parser_.prepare();
            const ssize_t n = ::recv(fd_, room.data(), room.size(), 0);
            if (n <= 0) return all;
            parser_.commit(static_cast<std::size_t>(n), ano::Clock::now());
            while (const auto frame = parser_.next()) all.emplace_back(frame->bytes().begin(), frame->bytes().end());
        }
    }

private:
    static sockaddr_in loopback(std::uint16_t port) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return address;
    }
    int fd_;
    std::uint16_t port_ = 0;
    ano::FrameParser parser_{ano::FrameParser::Options{.max_data = 60000}};
};

}    // namespace support
