#include <http/listeners/tcp_listener.hpp>
#include <sys/errors.hpp>

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <memory>
#include <string_view>

namespace anogate::http {
namespace {

struct Resolved {
    sockaddr_storage storage{};
    socklen_t size = 0;
};

/// Numeric addresses only; no name is looked up.
Expected<Resolved> resolve(const std::string& address, std::uint16_t port) {
    addrinfo hints{};
    hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (const int error = ::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found); error != 0)
        return Unexpected{address + ": " + ::gai_strerror(error)};
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> list{found, ::freeaddrinfo};
    Resolved resolved;
    resolved.size = list->ai_addrlen;
    std::copy_n(reinterpret_cast<const char*>(list->ai_addr), list->ai_addrlen, reinterpret_cast<char*>(&resolved.storage));
    return resolved;
}

struct End {
    std::string address;
    std::uint16_t port = 0;
};

/// An IPv4-mapped address (::ffff:a.b.c.d) becomes the IPv4 address.
End end_of(const sockaddr_storage& storage, socklen_t size) {
    char host[NI_MAXHOST], service[NI_MAXSERV];
    if (::getnameinfo(reinterpret_cast<const sockaddr*>(&storage), size, host, sizeof host, service, sizeof service,
                      NI_NUMERICHOST | NI_NUMERICSERV) != 0)
        return {};
    std::string address{host};
    constexpr std::string_view mapped = "::ffff:";
    if (address.starts_with(mapped) && address.find('.') != address.npos) address.erase(0, mapped.size());
    return {std::move(address), static_cast<std::uint16_t>(std::stoi(service))};
}

void switch_on(int fd, int level, int option, int value = 1) noexcept { ::setsockopt(fd, level, option, &value, sizeof value); }

}    // namespace

Expected<ListeningSocket> listen_tcp(const std::string& address, std::uint16_t port) {
    const auto where = resolve(address, port);
    if (!where) return Unexpected{where.error()};
    const int family = where->storage.ss_family;
    ListeningSocket made{UniqueFd{::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)}, family, 0};
    const auto failed = [&] { return Unexpected{error_text(address + " port " + std::to_string(port), errno)}; };
    if (!made.fd) return failed();
    switch_on(made.fd.get(), SOL_SOCKET, SO_REUSEADDR);
    if (family == AF_INET6) switch_on(made.fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, 0);
    if (::bind(made.fd.get(), reinterpret_cast<const sockaddr*>(&where->storage), where->size) != 0) return failed();
    if (::listen(made.fd.get(), SOMAXCONN) != 0) return failed();
    sockaddr_storage bound{};
    socklen_t size = sizeof bound;
    if (::getsockname(made.fd.get(), reinterpret_cast<sockaddr*>(&bound), &size) == 0) made.port = end_of(bound, size).port;
    return made;
}

std::string peer_of(int fd) {
    sockaddr_storage end{};
    socklen_t size = sizeof end;
    return ::getpeername(fd, reinterpret_cast<sockaddr*>(&end), &size) == 0 ? end_of(end, size).address : std::string{};
}

void prepare_tcp(int fd, ConnectionInfo& connection_info) {
    sockaddr_storage end{};
    socklen_t size = sizeof end;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&end), &size) == 0) {
        const End local = end_of(end, size);
        connection_info.local = local.address;
        connection_info.port = local.port;
    }
    connection_info.peer = peer_of(fd);
    switch_on(fd, IPPROTO_TCP, TCP_NODELAY);
    switch_on(fd, SOL_SOCKET, SO_KEEPALIVE);
    constexpr int quiet_seconds = 60, between_seconds = 15, probes = 4;
    switch_on(fd, IPPROTO_TCP, TCP_KEEPIDLE, quiet_seconds);
    switch_on(fd, IPPROTO_TCP, TCP_KEEPINTVL, between_seconds);
    switch_on(fd, IPPROTO_TCP, TCP_KEEPCNT, probes);
}

bool is_loopback(const std::string& address) {
    in_addr v4{};
    in6_addr v6{};
    if (::inet_pton(AF_INET, address.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == IN_LOOPBACKNET;
    return ::inet_pton(AF_INET6, address.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

}    // namespace anogate::http
