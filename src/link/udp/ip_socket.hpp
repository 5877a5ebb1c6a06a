// Opens UDP sockets, and converts endpoints for system calls.
#pragma once
#include <gateway/ip.hpp>
#include <link/link_error.hpp>
#include <sys/unique_fd.hpp>

#include <sys/socket.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace anogate {

/// An endpoint as a sockaddr for system calls.
struct SocketAddress {
    sockaddr_storage storage{};
    socklen_t size = 0;

    /// For an IPv6 socket (`v6_socket`) an IPv4 endpoint becomes an IPv4-mapped address.
    static SocketAddress of(const Endpoint& endpoint, bool v6_socket) noexcept;
    const sockaddr* get() const noexcept { return reinterpret_cast<const sockaddr*>(&storage); }
};
Endpoint endpoint_of(const sockaddr_storage& storage) noexcept;

/// The endpoint with the current index of its interface; std::nullopt: no such interface.
std::optional<Endpoint> endpoint_now(const EndpointSpec& written);
/// The error for a missing interface or address.
LinkError no_interface(const std::string& interface);
LinkError no_address(const std::string& address);

/// The current networks of our interfaces, loopback included.
std::vector<Network> own_networks();
/// The index of the interface that has `address` now; 0: none.
unsigned interface_of(const IpAddress& address);

/// The IPv4 source address of a datagram to `there`. 0.0.0.0 means the Internet: the address of the default route, or else of the
/// first interface with an address. std::nullopt: no route.
std::optional<IpAddress> source_towards(const IpAddress& there);

/// A non-blocking UDP socket bound to `local`, allowed to send broadcasts. [::] receives IPv4 too. With `interface` it receives
/// and sends only on that interface, independent of the address of a datagram.
Opened<UniqueFd> open_udp(const EndpointSpec& local, bool share_port, const std::string& interface = {});
/// Returns `stored`, with default options, if open_udp() would make the same socket and it is connected to `peer` (std::nullopt:
/// not connected). Otherwise `stored` is closed and the result is empty.
UniqueFd reuse_udp(UniqueFd stored, const EndpointSpec& local, const std::string& interface,
                   const std::optional<Endpoint>& peer = {});
/// The peer it is connected to; std::nullopt: none.
std::optional<Endpoint> connected_to(int fd) noexcept;
/// For a slow connection (a radio), because an urgent frame can't overtake data in the kernel's buffer.
void keep_send_buffer_small(int fd) noexcept;
/// The endpoint it is bound to, with the real port if it was bound to port 0.
Endpoint local_endpoint(int fd) noexcept;
/// Number of datagrams that the kernel dropped because they were not read in time.
std::int64_t kernel_drops(int fd) noexcept;

/// Bytes that the kernel has not sent yet: it keeps those for a neighbor that has not answered.
std::size_t unsent_datagrams(int fd) noexcept;

/// Sends one datagram. Returns 0 or errno.
int send_datagram(int fd, const Endpoint& to, std::span<const std::uint8_t> bytes, bool v6_socket) noexcept;

}    // namespace anogate
