#include <link/udp/ip_socket.hpp>
#include <sys/errors.hpp>

#include <ifaddrs.h>
#include <linux/sock_diag.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>

namespace anogate {
namespace {

constexpr int small_send_buffer = 8 << 10;    // bytes; a larger datagram is accepted when nothing else waits
constexpr int ip_receive_buffer = 4 << 20;    // bytes; the kernel limits it to net.core.rmem_max, except for root

IpAddress address_of(const sockaddr_in6& in) noexcept {
    IpAddress address{true, {}, in.sin6_scope_id};
    std::memcpy(address.bytes.data(), &in.sin6_addr, 16);
    if (IN6_IS_ADDR_V4MAPPED(&in.sin6_addr))
        return IpAddress::v4(address.bytes[12], address.bytes[13], address.bytes[14], address.bytes[15]);
    return address;
}

IpAddress address_of(const sockaddr_in& in) noexcept {
    IpAddress address;
    std::memcpy(address.bytes.data(), &in.sin_addr, 4);
    return address;
}

// Copies, because a sockaddr may not be aligned for `Address`.
template <class Address>
Address copy_as(const sockaddr* address) noexcept {
    Address copy;
    std::memcpy(&copy, address, sizeof copy);
    return copy;
}

std::uint8_t prefix_of(const sockaddr* mask) noexcept {
    const IpAddress bits = mask->sa_family == AF_INET6 ? address_of(copy_as<sockaddr_in6>(mask))
                                                       : address_of(copy_as<sockaddr_in>(mask));
    unsigned count = 0;
    for (const std::uint8_t byte : bits.bytes) count += static_cast<unsigned>(std::popcount(byte));
    return static_cast<std::uint8_t>(count);
}

template <class Call>
void for_each_own_network(Call call) {
    ifaddrs* list = nullptr;
    if (::getifaddrs(&list) != 0) return;
    for (const ifaddrs* i = list; i; i = i->ifa_next) {
        if (!i->ifa_addr || !i->ifa_netmask) continue;
        if (i->ifa_addr->sa_family == AF_INET)
            call(Network{address_of(copy_as<sockaddr_in>(i->ifa_addr)), prefix_of(i->ifa_netmask)}, i->ifa_name);
        else if (i->ifa_addr->sa_family == AF_INET6)
            call(Network{address_of(copy_as<sockaddr_in6>(i->ifa_addr)), prefix_of(i->ifa_netmask)}, i->ifa_name);
    }
    ::freeifaddrs(list);
}

}    // namespace

SocketAddress SocketAddress::of(const Endpoint& endpoint, bool v6_socket) noexcept {
    SocketAddress result;
    const IpAddress& ip = endpoint.address;
    if (!v6_socket && !ip.v6) {
        sockaddr_in in{};
        in.sin_family = AF_INET;
        in.sin_port = htons(endpoint.port);
        std::memcpy(&in.sin_addr, ip.bytes.data(), 4);
        std::memcpy(&result.storage, &in, result.size = sizeof in);
        return result;
    }
    sockaddr_in6 in{};
    in.sin6_family = AF_INET6;
    in.sin6_port = htons(endpoint.port);
    in.sin6_scope_id = ip.scope;
    if (ip.v6) {
        std::memcpy(&in.sin6_addr, ip.bytes.data(), 16);
    } else if (!ip.is_any()) {
        in.sin6_addr.s6_addr[10] = in.sin6_addr.s6_addr[11] = 0xFF;
        std::memcpy(&in.sin6_addr.s6_addr[12], ip.bytes.data(), 4);
    }
    std::memcpy(&result.storage, &in, result.size = sizeof in);
    return result;
}

Endpoint endpoint_of(const sockaddr_storage& storage) noexcept {
    if (storage.ss_family == AF_INET6) {
        sockaddr_in6 in;
        std::memcpy(&in, &storage, sizeof in);
        return {address_of(in), ntohs(in.sin6_port)};
    }
    sockaddr_in in;
    std::memcpy(&in, &storage, sizeof in);
    return {address_of(in), ntohs(in.sin_port)};
}

std::optional<Endpoint> endpoint_now(const EndpointSpec& written) {
    Endpoint endpoint = written;
    if (written.interface.empty()) return endpoint;
    endpoint.address.scope = ::if_nametoindex(written.interface.c_str());
    if (endpoint.address.scope == 0) {
        const std::string& digits = written.interface;
        std::from_chars(digits.data(), digits.data() + digits.size(), endpoint.address.scope);
        char name[IF_NAMESIZE];
        if (!::if_indextoname(endpoint.address.scope, name)) return std::nullopt;
    }
    return endpoint;
}

LinkError no_address(const std::string& address) {
    return {"no_address", "no network interface has the address " + address, {{"address", address}}};
}

LinkError no_interface(const std::string& interface) {
    return {"no_interface", "network interface " + interface + " not found", {{"interface", interface}}};
}

std::vector<Network> own_networks() {
    std::vector<Network> networks;
    for_each_own_network([&](const Network& network, const char*) { networks.push_back(network); });
    return networks;
}

unsigned interface_of(const IpAddress& address) {
    unsigned index = 0;
    for_each_own_network([&](const Network& network, const char* name) {
        if (network.address == address) index = ::if_nametoindex(name);
    });
    return index;
}

// Connecting a UDP socket sends nothing; the system only chooses the route.
std::optional<IpAddress> source_towards(const IpAddress& there) {
    const IpAddress world = IpAddress::v4(192, 0, 2, 1);    // reserved for documentation
    const UniqueFd fd{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    if (!fd) return std::nullopt;
    const int on = 1;
    ::setsockopt(fd.get(), SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
    const SocketAddress to = SocketAddress::of({there.is_any() ? world : there, 9}, false);
    if (::connect(fd.get(), to.get(), to.size) == 0) return local_endpoint(fd.get()).address;
    if (!there.is_any()) return std::nullopt;
    for (const Network& network : own_networks())
        if (!network.address.v6 && !network.address.is_loopback()) return network.address;
    return std::nullopt;
}

std::optional<Endpoint> connected_to(int fd) noexcept {
    sockaddr_storage storage{};
    socklen_t size = sizeof storage;
    if (::getpeername(fd, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return std::nullopt;
    return endpoint_of(storage);
}

namespace {

int option(int fd, int name) noexcept {
    int value = -1;
    socklen_t size = sizeof value;
    return ::getsockopt(fd, SOL_SOCKET, name, &value, &size) == 0 ? value : -1;
}

std::string device_of(int fd) {
    char name[IF_NAMESIZE] = {};
    socklen_t size = sizeof name;
    return ::getsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, name, &size) == 0 ? name : "";
}

// A connected socket has the source address of its route instead of the bound address; port 0 was replaced by a real port.
bool is_udp_at(int fd, const Endpoint& local, const std::string& interface, const std::optional<Endpoint>& peer) {
    if (option(fd, SO_DOMAIN) != (local.address.v6 ? AF_INET6 : AF_INET) || option(fd, SO_PROTOCOL) != IPPROTO_UDP) return false;
    const Endpoint bound = local_endpoint(fd);
    const bool any_address = peer && local.address.is_any();
    return (any_address || bound.address == local.address) && (local.port == 0 || bound.port == local.port) &&
           device_of(fd) == interface && connected_to(fd) == peer;
}

LinkError bind_error(const Endpoint& local, int error) {
    const std::string port = std::to_string(local.port);
    switch (error) {
    case EADDRINUSE: return {"port_in_use", "port " + port + " is in use by another program", {{"port", port}}};
    case EADDRNOTAVAIL: return no_address(local.address.text());
    case EACCES:
        return {"no_port_permission", "port " + port + ": permission denied (ports below 1024 need root)", {{"port", port}}};
    default: return error_text(local.text(), error);
    }
}

void set_options(int fd) noexcept {
    const int on = 1;
    ::setsockopt(fd, SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
    if (::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &ip_receive_buffer, sizeof ip_receive_buffer) != 0)
        ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &ip_receive_buffer, sizeof ip_receive_buffer);
    ::setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);    // Stamp
}

// Restores the default size, which a `rate` may have reduced.
void reset_send_buffer(int fd) noexcept {
    const UniqueFd fresh{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    const int size = option(fresh.get(), SO_SNDBUF) / 2;    // the kernel doubles the requested size
    if (size > 0) ::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &size, sizeof size);
}

}    // namespace

UniqueFd reuse_udp(UniqueFd stored, const EndpointSpec& written, const std::string& interface,
                   const std::optional<Endpoint>& peer) {
    const auto local = endpoint_now(written);
    if (!stored || !local || !is_udp_at(stored.get(), *local, interface, peer)) return {};
    set_options(stored.get());
    reset_send_buffer(stored.get());
    return stored;
}

Opened<UniqueFd> open_udp(const EndpointSpec& written, bool share_port, const std::string& interface) {
    const auto local = endpoint_now(written);
    if (!local) return NotOpened{no_interface(written.interface)};
    const int family = local->address.v6 ? AF_INET6 : AF_INET;
    UniqueFd fd{::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
    if (!fd) return Unexpected{error_text("can't open a UDP socket", errno)};
    set_options(fd.get());
    const int on = 1;
    const int off = 0;
    if (share_port) ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (local->address.v6) ::setsockopt(fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
    if (!interface.empty() &&
        ::setsockopt(fd.get(), SOL_SOCKET, SO_BINDTODEVICE, interface.data(), static_cast<socklen_t>(interface.size())) != 0)
        return NotOpened{errno == ENODEV ? no_interface(interface) : LinkError{error_text(interface, errno)}};
    const SocketAddress address = SocketAddress::of(*local, local->address.v6);
    if (::bind(fd.get(), address.get(), address.size) == 0) return fd;
    return NotOpened{bind_error(*local, errno)};
}

void keep_send_buffer_small(int fd) noexcept {
    ::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &small_send_buffer, sizeof small_send_buffer);
}

Endpoint local_endpoint(int fd) noexcept {
    sockaddr_storage storage{};
    socklen_t size = sizeof storage;
    ::getsockname(fd, reinterpret_cast<sockaddr*>(&storage), &size);
    return endpoint_of(storage);
}

std::size_t unsent_datagrams(int fd) noexcept {
    int bytes = 0;
    return ::ioctl(fd, SIOCOUTQ, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

std::int64_t kernel_drops(int fd) noexcept {
    std::array<std::uint32_t, SK_MEMINFO_VARS> info{};
    socklen_t size = sizeof info;
    return ::getsockopt(fd, SOL_SOCKET, SO_MEMINFO, info.data(), &size) == 0 ? info[SK_MEMINFO_DROPS] : 0;
}

int send_datagram(int fd, const Endpoint& to, std::span<const std::uint8_t> bytes, bool v6_socket) noexcept {
    const SocketAddress address = SocketAddress::of(to, v6_socket);
    return ::sendto(fd, bytes.data(), bytes.size(), MSG_DONTWAIT, address.get(), address.size) >= 0 ? 0 : errno;
}

}    // namespace anogate
