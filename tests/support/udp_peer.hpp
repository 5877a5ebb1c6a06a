// A UDP socket like that of a ground station; the kernel chooses its port.
#pragma once
#include "bytes.hpp"
#include "settings.hpp"

#include <link/udp/ip_socket.hpp>

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace support {

class UdpPeer {
public:
    explicit UdpPeer(const std::string& local = "127.0.0.1:0") {
        auto opened = anogate::open_udp(endpoint(local), false);
        if (!opened) throw std::runtime_error{opened.error().text};
        socket_ = std::move(*opened);
        local_ = anogate::local_endpoint(socket_.get());
        if (!std::getenv("ANOGATE_IN_VM")) return;
        const int room = 4 << 20;    // on an emulated machine, the program reads late
        ::setsockopt(fd(), SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room);
    }
    /// Its socket, for tests that set an option first.
    int fd() const { return socket_.get(); }
    const anogate::Endpoint& local() const { return local_; }
    std::uint16_t port() const { return local_.port; }
    /// A LINK text for a gateway that communicates with this peer.
    std::string link(const std::string& name) const { return "udp:" + local_.text() + ",bind=127.0.0.1:0,name=" + name; }

    bool send(const anogate::Endpoint& to, std::span<const std::uint8_t> datagram) {
        const auto address = anogate::SocketAddress::of(to, local_.address.v6);
        const auto once = [&] { return ::sendto(fd(), datagram.data(), datagram.size(), 0, address.get(), address.size); };
        ssize_t sent = once();
        if (sent < 0 && errno == EAGAIN) {    // its queue is full
            pollfd room{fd(), POLLOUT, 0};
            ::poll(&room, 1, 10'000);
            sent = once();
        }
        return sent == static_cast<ssize_t>(datagram.size());
    }
    bool send(const anogate::EndpointSpec& to, std::span<const std::uint8_t> datagram) {
        const auto now = anogate::endpoint_now(to);
        return now && send(*now, datagram);
    }
    bool send(std::uint16_t port, std::span<const std::uint8_t> datagram) {
        auto to = local_;
        if (to.address.is_any()) to.address = anogate::IpAddress::v4(127, 0, 0, 1);
        to.port = port;
        return send(to, datagram);
    }

    /// All datagrams received since the last call.
    std::vector<Bytes> datagrams() {
        std::vector<Bytes> result;
        sockaddr_storage from{};
        socklen_t size = sizeof from;
        for (ssize_t n;
             (n = ::recvfrom(socket_.get(), buffer_.data(), buffer_.size(), 0, reinterpret_cast<sockaddr*>(&from), &size)) >= 0;
             size = sizeof from) {
            result.emplace_back(buffer_.begin(), buffer_.begin() + n);
            last_sender_ = anogate::endpoint_of(from);
        }
        return result;
    }
    /// The frames of the datagrams received since the last call.
    std::vector<Bytes> frames() {
        std::vector<Bytes> all;
        for (const Bytes& datagram : datagrams())
            for (Bytes& one : split(datagram).frames) all.push_back(std::move(one));
        return all;
    }
    const anogate::Endpoint& last_sender() const { return last_sender_; }
    /// Reads again, and returns the bytes of all datagrams received so far.
    const Bytes& heard() {
        for (const Bytes& datagram : datagrams()) heard_.insert(heard_.end(), datagram.begin(), datagram.end());
        return heard_;
    }
    void forget() {
        heard();
        heard_.clear();
    }

private:
    anogate::UniqueFd socket_;
    anogate::Endpoint local_;
    anogate::Endpoint last_sender_;
    Bytes buffer_ = Bytes(65536);
    Bytes heard_;
};

}    // namespace support
