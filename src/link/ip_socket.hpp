// UDP sockets: endpoints as the kernel wants them, and opening.
#pragma once
#include <gateway/ip.hpp>
#include <link/link_error.hpp>
#include <link/unique_fd.hpp>

#include <sys/socket.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace anogate {

/// An endpoint as system calls take it.
struct SocketAddress {
    sockaddr_storage storage{};
    socklen_t size = 0;

    /// For a socket of IPv6 (`v6_socket`), an IPv4 endpoint is written as the mapped one.
    static SocketAddress of(const Endpoint& endpoint, bool v6_socket) noexcept;
    const sockaddr* get() const noexcept { return reinterpret_cast<const sockaddr*>(&storage); }
};
Endpoint endpoint_of(const sockaddr_storage& storage) noexcept;

/// With the number that its interface has now; nothing while there is no such interface.
std::optional<Endpoint> endpoint_now(const EndpointSpec& written);
/// What to say then.
LinkError no_interface(const std::string& interface);
LinkError no_address(const std::string& address);

/// The networks of our interfaces as they are now, loopback included.
std::vector<Network> own_networks();
/// The index of the interface that has `address` now; 0 for none.
unsigned interface_of(const IpAddress& address);

/// The IPv4 address that the system would give as the source of a datagram to `there`, or when that is 0.0.0.0, to the world:
/// by the default route, else of the first interface that has one. Nothing when no way leads there.
std::optional<IpAddress> source_towards(const IpAddress& there);

/// A non-blocking UDP socket bound to `local` as it is now, that may send to broadcast addresses. An IPv6 any-address takes IPv4 too.
/// With `interface` it neither hears nor says anything by another one, whatever address a datagram is for.
Opened<UniqueFd> open_udp(const EndpointSpec& local, bool share_port, const std::string& interface = {});
/// `stored`, made as new, if it is such a socket, connected to `peer` or to nobody; else it is closed.
UniqueFd reuse_udp(UniqueFd stored, const EndpointSpec& local, const std::string& interface,
                   const std::optional<Endpoint>& peer = {});
/// Whom it is connected to.
std::optional<Endpoint> connected_to(int fd) noexcept;
/// For a slow way (a radio): what the kernel holds can't be overtaken by what is urgent.
void keep_send_buffer_small(int fd) noexcept;
/// The endpoint it is bound to; port 0 became a real one.
Endpoint local_endpoint(int fd) noexcept;
/// Datagrams that the kernel dropped because they were not read in time.
std::int64_t kernel_drops(int fd) noexcept;

/// Sends one datagram; 0, or what errno says.
int send_datagram(int fd, const Endpoint& to, std::span<const std::uint8_t> bytes, bool v6_socket) noexcept;

}    // namespace anogate
