// SocketCAN: what state an interface is in, and the sockets on it. Errors are for the user to read.
#pragma once
#include <gateway/can_settings.hpp>
#include <link/link_error.hpp>
#include <link/unique_fd.hpp>

#include <string>

namespace anogate {

/// Whether `can` can be used now: not while it is absent, down, bus-off, not a CAN interface, or without CAN FD.
Opened<void> check_can_interface(const CanSettings& can);
/// Whether the bus itself is off: the controller has left it after too many errors.
bool can_bus_is_off(const std::string& interface);

/// A non-blocking raw socket that gets the frames under the ids of stream framing, our own excepted, and no others. `stored` is used
/// if it is one on this interface.
Opened<UniqueFd> open_can_stream(const CanSettings& can, UniqueFd stored = {});
/// A non-blocking ISO-TP socket: a datagram is one PDU. `stored` is used if it is one with these ids.
Opened<UniqueFd> open_can_isotp(const CanSettings& can, UniqueFd stored = {});
/// A non-blocking raw socket that gets error frames only.
Opened<UniqueFd> open_can_errors(const CanSettings& can);

/// What a failed read or write says of the interface.
LinkError can_error(const CanSettings& can, int error);

}    // namespace anogate
