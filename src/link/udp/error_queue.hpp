// ICMP errors for datagrams sent by a socket with many peers: the kernel queues each report with its destination, and also lets
// one later call fail, whatever its destination.
#pragma once
#include <gateway/ip.hpp>

#include <cstddef>
#include <functional>

namespace anogate {

/// Makes the kernel queue the reports of `fd`.
void keep_error_reports(int fd, bool v6_socket) noexcept;

/// Whether `error` of a call may come from such a report. It may also be an error of the call itself.
bool may_be_reported(int error) noexcept;

/// A datagram to `to` did not arrive, according to the host `by`. Anyone can forge it who knows the addresses and ports.
using OnUnreachable = std::function<void(const Endpoint& to, const IpAddress& by)>;

/// Reads at most 64 reports and calls `on_refused` for each "port unreachable" and `on_absent` for each "host unreachable". Returns
/// the number of reports from the network: while there are any, a call may have failed because of them.
std::size_t read_error_reports(int fd, const OnUnreachable& on_refused, const OnUnreachable& on_absent = {});

}    // namespace anogate
