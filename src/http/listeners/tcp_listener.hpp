// TCP sockets of the server.
#pragma once
#include <http/listeners/connection_info.hpp>
#include <sys/expected.hpp>
#include <sys/unique_fd.hpp>

#include <cstdint>
#include <string>

namespace anogate::http {

struct ListeningSocket {
    UniqueFd fd;
    int family = 0;
    std::uint16_t port = 0;    // the actual port: chosen by the kernel if 0 was requested
};

/// Listens at an IP address; [::] accepts IPv4 too.
Expected<ListeningSocket> listen_tcp(const std::string& address, std::uint16_t port);

/// The address of the remote end; empty: it has disconnected.
std::string peer_of(int fd);

/// Sets the addresses of a connected socket in `connection_info`; enables TCP_NODELAY and keep-alive on it.
void prepare_tcp(int fd, ConnectionInfo& connection_info);

/// 127.0.0.0/8 and ::1.
bool is_loopback(const std::string& address);

}    // namespace anogate::http
