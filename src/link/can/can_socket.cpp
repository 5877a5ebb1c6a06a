#include <gateway/can_settings.hpp>
#include <gateway/can_stream.hpp>
#include <link/can/can_bus.hpp>
#include <link/can/can_socket.hpp>
#include <sys/errors.hpp>

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/isotp.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

namespace anogate {
namespace {

// The kernel counts about 0.8 KB per frame. Bursts overflow its default of 208 KiB.
constexpr int can_receive_buffer = 4 << 20;
// The kernel raises it to its minimum, about six frames. An urgent frame can't overtake those in the kernel. And a queue shorter
// than the interface's own (10 by default) fails with EAGAIN and reports room; a longer one fails with ENOBUFS and does not.
constexpr int send_buffer = 1;

LinkError error_of(std::string_view id, std::string text, const CanSettings& can) {
    return {id, std::move(text), {{"interface", can.interface}}};
}

LinkError no_socket(int error, const char* what, const char* module) {
    if (error == EAFNOSUPPORT || error == EPROTONOSUPPORT || error == ESOCKTNOSUPPORT)
        return {"no_kernel_support",
                std::string{"the kernel has no support for "} + what + " (module " + module + ")",
                {{"what", what}}};
    return error_text(std::string{"no "} + what + " socket", error);
}

// No ioctl: for an absent interface the kernel would run modprobe each time.
bool is_there(const std::string& interface) {
    const std::unique_ptr<struct if_nameindex, decltype(&::if_freenameindex)> list{::if_nameindex(), &::if_freenameindex};
    for (const auto* i = list.get(); i && i->if_index != 0; ++i)
        if (interface == i->if_name) return true;
    return false;
}

ifreq request_for(const std::string& interface) {
    ifreq request{};
    interface.copy(request.ifr_name, IFNAMSIZ - 1);
    return request;
}

canid_t with_flag(const CanSettings& can, std::uint32_t id) { return can.extended ? id | CAN_EFF_FLAG : id; }

int protocol_of(int fd) {
    int protocol = -1, domain = -1;
    socklen_t size = sizeof protocol;
    if (::getsockopt(fd, SOL_SOCKET, SO_DOMAIN, &domain, &size) != 0 || domain != PF_CAN) return -1;
    return ::getsockopt(fd, SOL_SOCKET, SO_PROTOCOL, &protocol, &size) == 0 ? protocol : -1;
}

// A raw socket is bound to the interface only; ISO-TP also to its ids.
bool is_bound(int fd, const CanSettings& can, int protocol, const sockaddr_can& to) {
    sockaddr_can address{};
    socklen_t size = sizeof address;
    return protocol_of(fd) == protocol && ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
           address.can_ifindex != 0 && address.can_ifindex == static_cast<int>(::if_nametoindex(can.interface.c_str())) &&
           address.can_addr.tp.tx_id == to.can_addr.tp.tx_id && address.can_addr.tp.rx_id == to.can_addr.tp.rx_id;
}

Opened<UniqueFd> bound(UniqueFd fd, const CanSettings& can, sockaddr_can address = {}) {
    ifreq request = request_for(can.interface);
    if (::ioctl(fd.get(), SIOCGIFINDEX, &request) != 0) return NotOpened{can_error(can, errno)};
    address.can_family = AF_CAN;
    address.can_ifindex = request.ifr_ifindex;
    if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        return NotOpened{can_error(can, errno)};
    return fd;
}

sockaddr_can isotp_address(const CanSettings& can) {
    sockaddr_can address{};
    address.can_addr.tp.tx_id = with_flag(can, can.tx.value_or(0));
    address.can_addr.tp.rx_id = with_flag(can, can.rx.value_or(0));
    return address;
}

can_isotp_ll_options isotp_link_layer(const CanSettings& can) {
    can_isotp_ll_options link_layer{};
    link_layer.mtu = static_cast<std::uint8_t>(can.fd ? CANFD_MTU : CAN_MTU);
    link_layer.tx_dl = can.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN;
    link_layer.tx_flags = static_cast<std::uint8_t>(can.fd && can.brs ? CANFD_BRS : 0);
    return link_layer;
}

// The link layer options of a bound socket can't be changed.
bool has_link_layer(int fd, const CanSettings& can) {
    can_isotp_ll_options has{};
    const can_isotp_ll_options wanted = isotp_link_layer(can);
    socklen_t size = sizeof has;
    return ::getsockopt(fd, SOL_CAN_ISOTP, CAN_ISOTP_LL_OPTS, &has, &size) == 0 && has.mtu == wanted.mtu &&
           has.tx_dl == wanted.tx_dl && has.tx_flags == wanted.tx_flags;
}

Opened<UniqueFd> raw_socket() {
    UniqueFd fd{::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW)};
    if (!fd) return NotOpened{no_socket(errno, "CAN", "can-raw")};
    return fd;
}

}    // namespace

bool can_bus_is_off(const std::string& interface) {
    char carrier = '1';
    std::ifstream{"/sys/class/net/" + interface + "/carrier"}.get(carrier);
    return carrier == '0';
}

Opened<void> check_can_interface(const CanSettings& can) {
    const std::string& name = can.interface;
    static bool kernel_has_can = false;    // checked once: closing a CAN socket takes a while
    if (!kernel_has_can) {
        if (const auto socket = raw_socket(); !socket) return NotOpened{socket.error()};
        kernel_has_can = true;
    }
    if (!is_there(name)) return NotOpened{can_error(can, ENODEV)};
    const UniqueFd any{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    ifreq request = request_for(name);
    if (::ioctl(any.get(), SIOCGIFHWADDR, &request) != 0) return NotOpened{can_error(can, errno)};
    if (request.ifr_hwaddr.sa_family != ARPHRD_CAN) return NotOpened{error_of("not_can", name + " is not a CAN interface", can)};
    if (::ioctl(any.get(), SIOCGIFFLAGS, &request) != 0) return NotOpened{can_error(can, errno)};
    if ((request.ifr_flags & IFF_UP) == 0) return NotOpened{can_error(can, ENETDOWN)};
    if (can_bus_is_off(name)) return NotOpened{error_of("bus_off", bus_off_text(name), can)};
    if (can.fd && ::ioctl(any.get(), SIOCGIFMTU, &request) == 0 && request.ifr_mtu < static_cast<int>(CANFD_MTU))
        return NotOpened{error_of(
            "no_can_fd",
            name + " is not set up for CAN FD: ip link set " + name + " type can ... dbitrate RATE fd on (vcan: mtu 72)", can)};
    return {};
}

LinkError can_error(const CanSettings& can, int error) {
    switch (error) {
    case EADDRNOTAVAIL:    // what an ISO-TP socket reports for an absent interface
    case ENODEV: return error_of("no_interface", "network interface " + can.interface + " not found", can);
    case ENETDOWN: return error_of("interface_down", can.interface + " is down: ip link set " + can.interface + " up", can);
    default: return error_text(can.interface, error);
    }
}

Opened<UniqueFd> open_can_stream(const CanSettings& can, UniqueFd stored) {
    if (stored && !is_bound(stored.get(), can, CAN_RAW, {})) stored = {};
    auto socket = stored ? Opened<UniqueFd>{std::move(stored)} : raw_socket();
    if (!socket) return socket;
    const int fd = socket->get();
    std::vector<can_filter> filters;
    const canid_t kind = CAN_EFF_FLAG | CAN_RTR_FLAG;
    for (const auto [id, mask] : CanIds{can}.filters()) filters.push_back({with_flag(can, id), mask | kind});
    const int is_fd = can.fd;
    const auto size = static_cast<socklen_t>(filters.size() * sizeof filters[0]);
    if (::setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), size) != 0 ||
        (::setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &is_fd, sizeof is_fd) != 0 && can.fd))
        return NotOpened{can_error(can, errno)};
    if (::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &can_receive_buffer, sizeof can_receive_buffer) != 0)
        ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &can_receive_buffer, sizeof can_receive_buffer);
    ::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &send_buffer, sizeof send_buffer);
    return bound(std::move(*socket), can);
}

Opened<UniqueFd> open_can_isotp(const CanSettings& can, UniqueFd stored) {
    const sockaddr_can address = isotp_address(can);
    if (stored && is_bound(stored.get(), can, CAN_ISOTP, address) && has_link_layer(stored.get(), can)) return stored;
    stored = {};
    UniqueFd fd{::socket(PF_CAN, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_ISOTP)};
    if (!fd) return NotOpened{no_socket(errno, "ISO-TP", "can-isotp")};
    const can_isotp_ll_options link_layer = isotp_link_layer(can);
    if (can.fd && ::setsockopt(fd.get(), SOL_CAN_ISOTP, CAN_ISOTP_LL_OPTS, &link_layer, sizeof link_layer) != 0)
        return NotOpened{can_error(can, errno)};
    return bound(std::move(fd), can, address);
}

Opened<UniqueFd> open_can_errors(const CanSettings& can) {
    auto socket = raw_socket();
    if (!socket) return socket;
    const can_err_mask_t errors = CAN_ERR_MASK;
    ::setsockopt(socket->get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0);
    ::setsockopt(socket->get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
    return bound(std::move(*socket), can);
}

}    // namespace anogate
