// ICMP errors for datagrams sent by a socket with many peers: the kernel queues each report with its destination, and also lets
// one later call fail, whatever its destination.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>

#include <chrono>
#include <cstddef>
#include <functional>

namespace anogate {

/// Makes the kernel queue the reports of `fd`. `keep` false: it ignores them, and drops those in the queue.
void keep_error_reports(int fd, bool v6_socket, bool keep = true) noexcept;

/// Whether `error` of a call may come from such a report. It may also be an error of the call itself.
bool may_be_reported(int error) noexcept;

/// A datagram to `to` did not arrive, according to the host `by`. Anyone can forge it who knows the addresses and ports.
using OnUnreachable = std::function<void(const Endpoint& to, const IpAddress& by)>;

/// Limits the reports that a socket keeps: with a flood of forged ones, hardly any call would succeed.
class ReportLimit {
public:
    static constexpr std::size_t max_reports = 1000;
    static constexpr ano::Duration period = std::chrono::seconds{1};

    /// `count` reports were read. True: too many within a period; no more should be kept for a period.
    bool is_exceeded(std::size_t count, ano::TimePoint now) noexcept {
        if (now - since_ >= period) {
            since_ = now;
            count_ = 0;
        }
        count_ += count;
        return count_ > max_reports;
    }

private:
    ano::TimePoint since_{};
    std::size_t count_ = 0;
};

/// Reads at most 64 reports and calls `on_refused` for each "port unreachable" and `on_absent` for each "host unreachable". Returns
/// the number of reports from the network: while there are any, a call may have failed because of them.
std::size_t read_error_reports(int fd, const OnUnreachable& on_refused, const OnUnreachable& on_absent = {});

}    // namespace anogate
