// UDP sockets: endpoints as the kernel wants them, opening, and sending an outbox in batches.
#pragma once
#include <gateway/ip.hpp>
#include <gateway/outbox.hpp>
#include <link/descriptor.hpp>

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

/// The networks of our interfaces as they are now, loopback included.
std::vector<Network> own_networks();
/// The index of the interface that has `address` now; 0 for none.
unsigned interface_of(const IpAddress& address);

/// The IPv4 address that the system would give as the source of a datagram to `there`, or when that is 0.0.0.0, to the world:
/// by the default route, else of the first interface that has one. Nothing when no way leads there.
std::optional<IpAddress> source_towards(const IpAddress& there);

struct OpenedSocket {
    UniqueFd fd;
    std::string error;
};
/// A non-blocking UDP socket bound to `local`, that may send to broadcast addresses. An IPv6 any-address takes IPv4 too.
OpenedSocket open_udp(const Endpoint& local, bool share_port);
/// The endpoint it is bound to; port 0 became a real one.
Endpoint local_endpoint(int fd) noexcept;
/// Datagrams that the kernel dropped because they were not read in time.
std::int64_t kernel_drops(int fd) noexcept;

enum class SendResult {
    done,         // the outbox is empty
    full,         // go on when the socket is writable
    no_memory,    // go on a little later: the system says so without saying when
    broken,       // the socket is of no use any more; errno says why
};
/// Sends one datagram; 0, or what errno says.
int send_datagram(int fd, const Endpoint& to, std::span<const std::uint8_t> bytes, bool v6_socket) noexcept;

struct SendReport {
    SendResult result = SendResult::done;
    int error = 0;                // the last errno; 0: none
    std::uint64_t refused = 0;    // "connection refused" answers to earlier datagrams
};
/// Sends what waits, a datagram a frame, to `to` (nullptr: the connected peer), with one system call for many.
/// Frames that can't go are counted in the outbox by cause.
SendReport send_all(int fd, Outbox& outbox, const SocketAddress* to) noexcept;

}  // namespace anogate
