// The sockets and serial ports to ground stations. Each gives its bytes to a MavlinkBridge.
#pragma once
#include <mavlink/bridge.hpp>
#include <sys/asio_fwd.hpp>

#include <memory>
#include <span>
#include <string>

namespace anogate::mavlink {

class StationLink {
public:
    virtual ~StationLink() = default;
    /// False: another link has this connection. `accepted`: whether the packet was sent, or will be.
    virtual bool transmit(std::size_t connection, std::span<const std::uint8_t> packet, bool& accepted) = 0;
    /// At least every 100 ms: opens again what was lost, forgets stations that are silent.
    virtual void on_time(ano::TimePoint now) = 0;
};

/// One that sends to a configured station, and receives only from it. `place`: as checked by check_mavlink_settings().
std::unique_ptr<StationLink> make_udp(asio::io_context& io, MavlinkBridge& bridge, const std::string& place);
/// One for stations that send first; at most 16, each until it is silent for 30 s.
std::unique_ptr<StationLink> make_udp_listen(asio::io_context& io, MavlinkBridge& bridge, const std::string& place);
std::unique_ptr<StationLink> make_tcp_listen(asio::io_context& io, MavlinkBridge& bridge, const std::string& place);
/// A serial port, which is opened again when it is plugged in.
std::unique_ptr<StationLink> make_serial(asio::io_context& io, MavlinkBridge& bridge, const std::string& device,
                                         std::uint32_t baud);

}    // namespace anogate::mavlink
