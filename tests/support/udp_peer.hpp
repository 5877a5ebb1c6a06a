// A UDP socket as a ground station would have one; the kernel chooses its port.
#pragma once
#include "bytes.hpp"
#include "settings.hpp"

#include <link/ip_socket.hpp>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace support {

class UdpPeer {
public:
    explicit UdpPeer(const std::string& local = "127.0.0.1:0") {
        auto opened = anogate::open_udp(endpoint(local), false);
        if (!opened) throw std::runtime_error{opened.error()};
        socket_ = std::move(*opened);
        local_ = anogate::local_endpoint(socket_.get());
    }
    /// Its own socket for tests that need an option set first.
    int fd() const { return socket_.get(); }
    const anogate::Endpoint& local() const { return local_; }
    std::uint16_t port() const { return local_.port; }

    bool send(const anogate::Endpoint& to, std::span<const std::uint8_t> datagram) {
        const auto address = anogate::SocketAddress::of(to, local_.address.v6);
        return ::sendto(socket_.get(), datagram.data(), datagram.size(), 0, address.get(), address.size) ==
               static_cast<ssize_t>(datagram.size());
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

    /// Every datagram that has come since the last call.
    std::vector<Bytes> datagrams() {
        std::vector<Bytes> result;
        Bytes buffer(65536);
        sockaddr_storage from{};
        socklen_t size = sizeof from;
        for (ssize_t n;
             (n = ::recvfrom(socket_.get(), buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &size)) >= 0;
             size = sizeof from) {
            result.emplace_back(buffer.begin(), buffer.begin() + n);
            last_sender_ = anogate::endpoint_of(from);
        }
        return result;
    }
    const anogate::Endpoint& last_sender() const { return last_sender_; }
    /// Reads on, and gives all that ever came, one datagram behind the other.
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
    Bytes heard_;
};

}    // namespace support
