// Opens TCP sockets with the options of our links.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>
#include <link/link_error.hpp>
#include <link/tcp/in_flight_limit.hpp>
#include <sys/unique_fd.hpp>

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace anogate {

/// Limit for the unsent bytes of a connection in the kernel, because an urgent frame can't pass them.
inline constexpr std::size_t max_not_sent = 2048;

/// No delay for small frames; writable only below max_not_sent. A connection whose other end is silent for about `dead_after` is
/// closed by the kernel, whether we send or only read.
void set_tcp_options(int fd, ano::Duration dead_after) noexcept;

/// A non-blocking socket that begins to connect: it is writable when connecting has succeeded or failed, see connect_error().
Opened<UniqueFd> begin_connect(const Endpoint& to, ano::Duration dead_after);
/// Ends the connection; what the kernel still holds is not sent.
void abort_connection(int fd) noexcept;
/// Whether all unacknowledged data waits because the peer does not read, and not because of the path.
bool waits_for_reader(int fd) noexcept;
/// 0: connected; otherwise errno.
int connect_error(int fd) noexcept;

/// A non-blocking listening socket. [::] accepts IPv4 too.
Opened<UniqueFd> listen_tcp(const EndpointSpec& local);
struct Accepted {
    UniqueFd fd;
    Endpoint peer;
};
/// The next connection; without a descriptor: none, see errno.
Accepted accept_tcp(int listener) noexcept;

/// Bytes in the kernel that have not been sent even once.
std::size_t not_sent(int fd) noexcept;
/// Written bytes that the other end has not acknowledged.
std::size_t unacknowledged(int fd) noexcept;
/// Zero: not measured yet.
InFlightLimit::RoundTrip round_trip(int fd) noexcept;

}    // namespace anogate
