// TCP sockets for the server.
#pragma once
#include <http/door.hpp>
#include <link/expected.hpp>
#include <link/unique_fd.hpp>

#include <cstdint>
#include <string>

namespace anogate::http {

struct ListeningSocket {
    UniqueFd fd;
    int family = 0;
    std::uint16_t port = 0;    // which the kernel chose, where 0 was asked for
};

/// Listens at an IP address; [::] takes IPv4 too.
Expected<ListeningSocket> listen_tcp(const std::string& address, std::uint16_t port);

/// Fills in who is at the ends of a connected socket, and lets it send without delay and notice a peer that is gone.
void prepare_tcp(int fd, Door& door);

/// 127.0.0.0/8 and ::1.
bool is_loopback(const std::string& address);

}    // namespace anogate::http
