// A blocking client of a control socket.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

namespace support {

/// A blocking connection to a Unix socket; -1 if nothing listens. Connecting and each read end after `limit`.
int connect_unix(const std::string& path, std::chrono::seconds limit = std::chrono::seconds{30});
/// The same to a port of 127.0.0.1, from another address of this machine, "127.9.0.1".
int connect_tcp(std::uint16_t port, const std::string& from = "127.0.0.1");
std::string read_to_end(int fd);

/// Sends one request over its own connection. Returns the whole response; empty: there is none.
std::string http(const std::string& socket, const std::string& request, std::chrono::seconds limit = std::chrono::seconds{30});
std::string http(std::uint16_t port, const std::string& request, const std::string& from = "127.0.0.1");
std::string body_of(const std::string& answer);

}    // namespace support
