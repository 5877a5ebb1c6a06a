#include <ros2/interfaces.hpp>
#include <sys/errors.hpp>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <memory>

namespace anogate {
namespace {

constexpr auto settle_time = std::chrono::milliseconds{200};    // several changes at a time are one

}    // namespace

std::set<InterfaceAddress> interface_addresses(const std::vector<std::string>& names) {
    constexpr unsigned carrier = IFF_UP | IFF_RUNNING;    // a DDS library leaves out the others, and never looks again
    ifaddrs* first = nullptr;
    std::set<InterfaceAddress> addresses;
    if (::getifaddrs(&first) != 0) return addresses;
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list{first, ::freeifaddrs};
    for (const ifaddrs* one = list.get(); one != nullptr; one = one->ifa_next) {
        if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET || (one->ifa_flags & carrier) != carrier) continue;
        if (!names.empty() && std::find(names.begin(), names.end(), one->ifa_name) == names.end()) continue;
        char text[INET_ADDRSTRLEN] = {};
        const void* const address = &reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr;
        if (::inet_ntop(AF_INET, address, text, sizeof text) != nullptr) addresses.emplace(::if_nametoindex(one->ifa_name), text);
    }
    return addresses;
}

bool must_rejoin(const std::set<InterfaceAddress>& joined, const std::set<InterfaceAddress>& now) {
    return !std::includes(joined.begin(), joined.end(), now.begin(), now.end());
}

InterfaceWatch::InterfaceWatch(asio::io_context& io, std::function<void()> call)
    : descriptor_{io}, settled_{io}, call_{std::move(call)} {}

Expected<void> InterfaceWatch::start() {
    UniqueFd fd{::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE)};
    sockaddr_nl address{};
    address.nl_family = AF_NETLINK;
    address.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR;
    if (!fd || ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        return Unexpected{error_text("changes of network interfaces are not reported", errno)};
    descriptor_.open(std::move(fd));
    descriptor_.read_with([this] { read(); });
    return {};
}

void InterfaceWatch::stop() {
    descriptor_.close();
    settled_.cancel();
}

// The content does not matter: the addresses are read afterwards. Nor do lost messages.
void InterfaceWatch::read() {
    std::array<char, 8192> message;
    while (::recv(descriptor_.fd(), message.data(), message.size(), 0) >= 0) {}
    if (std::exchange(waits_, true)) return;
    settled_.expires_after(settle_time);
    settled_.async_wait([this](error_code ec) {
        waits_ = false;
        if (!ec) call_();
    });
}

}    // namespace anogate
