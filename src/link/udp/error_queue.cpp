#include <link/udp/error_queue.hpp>
#include <link/udp/ip_socket.hpp>

#include <netinet/icmp6.h>
#include <netinet/in.h>
#include <netinet/ip_icmp.h>

#include <linux/errqueue.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace anogate {
namespace {

constexpr std::size_t max_reports = 64;    // per call: a flood of reports must not block the loop

bool from_network(const sock_extended_err& report) noexcept {
    return report.ee_origin == SO_EE_ORIGIN_ICMP || report.ee_origin == SO_EE_ORIGIN_ICMP6;
}

bool nothing_listens(const sock_extended_err& report) noexcept {
    return (report.ee_origin == SO_EE_ORIGIN_ICMP && report.ee_type == ICMP_DEST_UNREACH &&
            report.ee_code == ICMP_PORT_UNREACH) ||
           (report.ee_origin == SO_EE_ORIGIN_ICMP6 && report.ee_type == ICMP6_DST_UNREACH &&
            report.ee_code == ICMP6_DST_UNREACH_NOPORT);
}

bool host_is_absent(const sock_extended_err& report) noexcept {
    return (report.ee_origin == SO_EE_ORIGIN_ICMP && report.ee_type == ICMP_DEST_UNREACH &&
            report.ee_code == ICMP_HOST_UNREACH) ||
           (report.ee_origin == SO_EE_ORIGIN_ICMP6 && report.ee_type == ICMP6_DST_UNREACH &&
            report.ee_code == ICMP6_DST_UNREACH_ADDR);
}

IpAddress sender_of(const cmsghdr& c) noexcept {
    sockaddr_storage from{};
    const std::size_t rest = c.cmsg_len - std::min<std::size_t>(c.cmsg_len, CMSG_LEN(sizeof(sock_extended_err)));
    std::memcpy(&from, CMSG_DATA(&c) + sizeof(sock_extended_err), std::min(rest, sizeof from));
    return endpoint_of(from).address;
}

}    // namespace

void keep_error_reports(int fd, bool v6_socket, bool keep) noexcept {
    const int on = keep ? 1 : 0;
    ::setsockopt(fd, IPPROTO_IP, IP_RECVERR, &on, sizeof on);    // also for an IPv6 socket, which may send IPv4
    if (v6_socket) ::setsockopt(fd, IPPROTO_IPV6, IPV6_RECVERR, &on, sizeof on);
}

bool may_be_reported(int error) noexcept {
    switch (error) {
    case ECONNREFUSED:
    case EHOSTUNREACH:
    case ENETUNREACH:
    case EHOSTDOWN:
    case ENONET:
    case ENOPROTOOPT:
    case EOPNOTSUPP:
    case EPROTO:
    case EACCES:
    case EMSGSIZE: return true;
    default: return false;
    }
}

std::size_t read_error_reports(int fd, const OnUnreachable& on_refused, const OnUnreachable& on_absent) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < max_reports; ++i) {
        sockaddr_storage to{};
        alignas(cmsghdr) char control[512];
        msghdr message{};
        message.msg_name = &to;
        message.msg_namelen = sizeof to;
        message.msg_control = control;
        message.msg_controllen = sizeof control;
        if (::recvmsg(fd, &message, MSG_ERRQUEUE | MSG_DONTWAIT) < 0) break;
        for (cmsghdr* c = CMSG_FIRSTHDR(&message); c; c = CMSG_NXTHDR(&message, c)) {
            const bool is_report = (c->cmsg_level == IPPROTO_IP && c->cmsg_type == IP_RECVERR) ||
                                   (c->cmsg_level == IPPROTO_IPV6 && c->cmsg_type == IPV6_RECVERR);
            if (!is_report) continue;
            sock_extended_err report;
            std::memcpy(&report, CMSG_DATA(c), sizeof report);
            if (from_network(report)) ++count;
            if (message.msg_namelen == 0) continue;
            if (nothing_listens(report)) on_refused(endpoint_of(to), sender_of(*c));
            else if (on_absent && host_is_absent(report)) on_absent(endpoint_of(to), sender_of(*c));
        }
    }
    return count;
}

}    // namespace anogate
