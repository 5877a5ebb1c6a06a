// The remote end of a TCP link: a socket that listens, or one that connects.
#pragma once
#include "bytes.hpp"
#include "settings.hpp"

#include <link/tcp/tcp_socket.hpp>
#include <link/udp/ip_socket.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace support {

class TcpPeer {
public:
    TcpPeer() = default;
    explicit TcpPeer(anogate::UniqueFd fd) : fd_{std::move(fd)} {}
    /// Starts to connect, without waiting for the other end.
    explicit TcpPeer(const std::string& to) {
        auto begun = anogate::begin_connect(endpoint(to), std::chrono::hours{1});
        if (!begun) throw std::runtime_error{begun.error().text};
        fd_ = std::move(*begun);
    }
    explicit TcpPeer(std::uint16_t port) : TcpPeer{"127.0.0.1:" + std::to_string(port)} {}

    int fd() const { return fd_.get(); }
    explicit operator bool() const { return static_cast<bool>(fd_); }
    bool send(std::span<const std::uint8_t> bytes) {
        return ::send(fd(), bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
    }
    /// Reads again, and returns all bytes received so far.
    const Bytes& heard() {
        Bytes more(65536);
        for (ssize_t n; (n = ::read(fd(), more.data(), more.size())) > 0;)
            heard_.insert(heard_.end(), more.begin(), more.begin() + n);
        return heard_;
    }
    /// True if the other end has closed the connection.
    bool is_closed() {
        std::uint8_t byte;
        const ssize_t n = ::recv(fd(), &byte, 1, MSG_PEEK | MSG_DONTWAIT);
        return n == 0 || (n < 0 && errno != EAGAIN);
    }
    void close() { fd_ = anogate::UniqueFd{}; }

private:
    anogate::UniqueFd fd_;
    Bytes heard_;
};

class TcpListener {
public:
    explicit TcpListener(const std::string& local = "127.0.0.1:0") {
        auto opened = anogate::listen_tcp(endpoint(local));
        if (!opened) throw std::runtime_error{opened.error().text};
        fd_ = std::move(*opened);
        local_ = anogate::local_endpoint(fd_.get());
    }
    int fd() const { return fd_.get(); }
    std::uint16_t port() const { return local_.port; }
    std::string address() const { return local_.text(); }
    /// A LINK text for a gateway that is to connect.
    std::string link(const std::string& name) const { return "tcp:" + local_.text() + ",name=" + name; }
    /// Accepts the next connection; false: none waits.
    bool accept(TcpPeer& into) {
        anogate::Accepted next = anogate::accept_tcp(fd_.get());
        if (!next.fd) return false;
        into = TcpPeer{std::move(next.fd)};
        return true;
    }

private:
    anogate::UniqueFd fd_;
    anogate::Endpoint local_;
};

}    // namespace support
