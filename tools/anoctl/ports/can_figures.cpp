#include "can_figures.hpp"

#include <sys/unique_fd.hpp>

#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <array>
#include <cstring>
#include <optional>
#include <vector>

namespace anoctl {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// The value of the first attribute of this type; empty: none.
Bytes attribute(Bytes attributes, unsigned type) {
    while (attributes.size() >= sizeof(rtattr)) {
        rtattr head{};
        std::memcpy(&head, attributes.data(), sizeof head);
        if (head.rta_len < sizeof head || head.rta_len > attributes.size()) return {};
        if ((head.rta_type & NLA_TYPE_MASK) == type) return attributes.subspan(sizeof head, head.rta_len - sizeof head);
        const std::size_t whole = (std::size_t{head.rta_len} + 3) & ~std::size_t{3};
        if (whole > attributes.size()) return {};
        attributes = attributes.subspan(whole);
    }
    return {};
}

template <class Struct>
std::optional<Struct> read_as(Bytes bytes) {
    if (bytes.size() < sizeof(Struct)) return std::nullopt;
    Struct value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
}

struct Request {
    nlmsghdr head{};
    ifinfomsg link{};
};

}    // namespace

CanFigures can_figures_in(Bytes message) {
    const auto head = read_as<nlmsghdr>(message);
    if (!head || head->nlmsg_type != RTM_NEWLINK || message.size() < sizeof(Request)) return {};
    const Bytes link_info = attribute(message.subspan(sizeof(Request)), IFLA_LINKINFO);
    const Bytes kind = attribute(link_info, IFLA_INFO_KIND);    // with a terminating NUL
    if (std::string_view{reinterpret_cast<const char*>(kind.data()), kind.size()}.substr(0, 4) != std::string_view{"can\0", 4})
        return {};
    const Bytes info = attribute(link_info, IFLA_INFO_DATA);
    constexpr std::array<std::string_view, 6> states{"error-active", "error-warning", "error-passive",
                                                     "bus-off",      "stopped",       "sleeping"};
    CanFigures figures;
    if (const auto state = read_as<std::uint32_t>(attribute(info, IFLA_CAN_STATE)); state && *state < states.size())
        figures.bus = states[*state];
    if (const auto timing = read_as<can_bittiming>(attribute(info, IFLA_CAN_BITTIMING))) figures.bitrate = timing->bitrate;
    if (const auto timing = read_as<can_bittiming>(attribute(info, IFLA_CAN_DATA_BITTIMING)))
        figures.data_bitrate = timing->bitrate;
    return figures;
}

CanFigures can_figures(const std::string& interface) {
    const anogate::UniqueFd fd{::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)};
    Request request;
    request.head.nlmsg_len = sizeof request;
    request.head.nlmsg_type = RTM_GETLINK;
    request.head.nlmsg_flags = NLM_F_REQUEST;
    request.link.ifi_index = static_cast<int>(::if_nametoindex(interface.c_str()));
    const timeval patience{1, 0};
    if (!fd || request.link.ifi_index == 0 || ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0 ||
        ::send(fd.get(), &request, sizeof request, 0) != sizeof request)
        return {};
    std::vector<std::uint8_t> answer(32768);
    const ssize_t n = ::recv(fd.get(), answer.data(), answer.size(), 0);
    return n > 0 ? can_figures_in(Bytes{answer}.first(static_cast<std::size_t>(n))) : CanFigures{};
}

}    // namespace anoctl
