// SocketCAN: the state of an interface, and sockets on it. Errors are texts for the user.
#pragma once
#include <gateway/can_settings.hpp>
#include <link/link_error.hpp>
#include <sys/unique_fd.hpp>

#include <string>

namespace anogate {

/// Whether `can` is usable now. An error if it is absent, down, bus-off, not a CAN interface, or lacks the CAN FD it needs.
Opened<void> check_can_interface(const CanSettings& can);
/// Whether the controller is bus-off: it left the bus after too many errors.
bool can_bus_is_off(const std::string& interface);

/// A non-blocking raw socket that receives only frames with ids of stream framing, except our own id. `stored` is reused if it is
/// on this interface.
Opened<UniqueFd> open_can_stream(const CanSettings& can, UniqueFd stored = {});
/// A non-blocking ISO-TP socket: a datagram is one PDU. `stored` is reused if it has these ids.
Opened<UniqueFd> open_can_isotp(const CanSettings& can, UniqueFd stored = {});
/// A non-blocking raw socket that receives error frames only.
Opened<UniqueFd> open_can_errors(const CanSettings& can);

/// The error text for a failed read or write.
LinkError can_error(const CanSettings& can, int error);

}    // namespace anogate
