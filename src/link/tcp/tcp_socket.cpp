#include <link/tcp/tcp_socket.hpp>
#include <link/udp/ip_socket.hpp>
#include <sys/errors.hpp>

#include <linux/sockios.h>
#include <linux/tcp.h>    // for tcp_info with the shortest round trip, which netinet/tcp.h lacks
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

namespace anogate {
namespace {

constexpr int tcp_send_buffer = 32 * 1024;    // the kernel doubles it
constexpr int probes = 3;
constexpr std::chrono::seconds longest_between_probes{32767};    // of Linux; TCP_USER_TIMEOUT may be longer

void set_option(int fd, int level, int option, int value) noexcept { ::setsockopt(fd, level, option, &value, sizeof value); }

UniqueFd tcp_socket(bool v6) noexcept {
    return UniqueFd{::socket(v6 ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
}

std::size_t queued(int fd, unsigned long request) noexcept {
    int bytes = 0;
    return ::ioctl(fd, request, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

tcp_info info_of(int fd) noexcept {
    tcp_info info{};    // members that an old kernel does not know stay zero
    socklen_t size = sizeof info;
    return ::getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 ? info : tcp_info{};
}

LinkError listen_error(const EndpointSpec& local, int error) {
    const std::string port = std::to_string(local.port);
    if (error == EADDRINUSE)
        return {
            "port_in_use", "TCP port " + port + " is in use by another program (find it with sudo ss -ltnp)", {{"port", port}}};
    if (error == EADDRNOTAVAIL) return no_address(local.text());
    if (error == EACCES) return {"no_port_permission", "no permission to listen on TCP port " + port, {{"port", port}}};
    return error_text(local.text(), error);
}

}    // namespace

void set_tcp_options(int fd, ano::Duration dead_after) noexcept {
    using namespace std::chrono;
    const auto idle = std::clamp(duration_cast<seconds>(dead_after / 2), seconds{1}, longest_between_probes);
    const auto between = std::clamp(duration_cast<seconds>(dead_after / 5), seconds{1}, longest_between_probes);
    set_option(fd, IPPROTO_TCP, TCP_NODELAY, 1);
    set_option(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, static_cast<int>(2 * max_not_sent));
    set_option(fd, SOL_SOCKET, SO_SNDBUF, tcp_send_buffer);
    set_option(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
    set_option(fd, IPPROTO_TCP, TCP_KEEPIDLE, static_cast<int>(idle.count()));
    set_option(fd, IPPROTO_TCP, TCP_KEEPINTVL, static_cast<int>(between.count()));
    set_option(fd, IPPROTO_TCP, TCP_KEEPCNT, probes);
    set_option(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, static_cast<int>(duration_cast<milliseconds>(dead_after).count()));
}

Opened<UniqueFd> begin_connect(const Endpoint& to, ano::Duration dead_after) {
    UniqueFd fd = tcp_socket(to.address.v6);
    if (!fd) return Unexpected{error_text("can't open a TCP socket", errno)};
    set_tcp_options(fd.get(), dead_after);
    const SocketAddress address = SocketAddress::of(to, to.address.v6);
    if (::connect(fd.get(), address.get(), address.size) == 0 || errno == EINPROGRESS) return fd;
    return Unexpected{error_text(to.text(), errno)};
}

// The other descriptor of an encrypted connection would keep a closed socket alive.
void abort_connection(int fd) noexcept {
    sockaddr none{};
    none.sa_family = AF_UNSPEC;
    static_cast<void>(::connect(fd, &none, sizeof none));    // otherwise it is closed all the same
}

int connect_error(int fd) noexcept {
    int error = 0;
    socklen_t size = sizeof error;
    return ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
}

Opened<UniqueFd> listen_tcp(const EndpointSpec& written) {
    const auto local = endpoint_now(written);
    if (!local) return NotOpened{no_interface(written.interface)};
    UniqueFd fd = tcp_socket(local->address.v6);
    if (!fd) return Unexpected{error_text("can't open a TCP socket", errno)};
    set_option(fd.get(), SOL_SOCKET, SO_REUSEADDR, 1);
    if (local->address.v6) set_option(fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, 0);
    const SocketAddress address = SocketAddress::of(*local, local->address.v6);
    if (::bind(fd.get(), address.get(), address.size) == 0 && ::listen(fd.get(), SOMAXCONN) == 0) return fd;
    return NotOpened{listen_error(written, errno)};
}

Accepted accept_tcp(int listener) noexcept {
    sockaddr_storage storage{};
    socklen_t size = sizeof storage;
    UniqueFd fd{::accept4(listener, reinterpret_cast<sockaddr*>(&storage), &size, SOCK_NONBLOCK | SOCK_CLOEXEC)};
    return {std::move(fd), endpoint_of(storage)};
}

std::size_t not_sent(int fd) noexcept { return queued(fd, SIOCOUTQNSD); }

std::size_t unacknowledged(int fd) noexcept { return queued(fd, SIOCOUTQ); }

InFlightLimit::RoundTrip round_trip(int fd) noexcept {
    const tcp_info info = info_of(fd);
    return {std::chrono::microseconds{info.tcpi_rtt}, std::chrono::microseconds{info.tcpi_min_rtt}};
}

// A firewall of this computer keeps data unsent as well, although the peer has room for it.
bool waits_for_reader(int fd) noexcept {
    const std::size_t waiting = unacknowledged(fd);
    return waiting == not_sent(fd) && info_of(fd).tcpi_snd_wnd < waiting;
}

}    // namespace anogate
