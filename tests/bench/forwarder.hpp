// A forwarding process, anogated or a bare loop, and the sockets that receive its output.
#pragma once
#include "gateway_process.hpp"
#include "processes.hpp"
#include "talking_ptys.hpp"
#include "traffic_ends.hpp"

#include <support/child.hpp>

#include <memory>

namespace bench {

inline constexpr std::uint8_t target = 0x42;    // a device at the first receiver
inline constexpr std::uint8_t everybody = 0xFF;
inline constexpr std::size_t mtu = 1400;    // of packed datagrams, bytes
inline const std::string unpacked = ",pack=false";

struct Forwarder {
    std::vector<std::unique_ptr<Socket>> takers;
    std::unique_ptr<GatewayProcess> gateway;    // alternatively
    std::unique_ptr<support::Child> loop;
    std::uint64_t* loop_frames = nullptr;
    std::uint16_t port = 0;    // its listening port
    std::unique_ptr<TalkingPtys> ptys;

    explicit Forwarder(std::size_t outputs);
    pid_t pid() const { return gateway ? gateway->pid() : loop->pid(); }
    /// Sent to the first receiver so far.
    std::uint64_t frames() const;
    std::vector<int> taken_at() const;
    /// Arguments of anogated for links to the receivers, each with `keys`.
    std::vector<std::string> links_out(const std::string& keys) const;
};

/// `keys` are those of the links to the receivers.
Forwarder anogated_from_udp(const std::string& program, std::size_t outputs, const std::string& keys,
                            const std::vector<std::string>& tracer = {});
Forwarder anogated_from_pty(const std::string& program);
/// `pack` as for bare_loop().
Forwarder bare_from_udp(std::size_t outputs, std::size_t pack = 0);

}    // namespace bench
