// Whose logs and faults count.
#pragma once
#include <cstdint>

namespace anogate {

class Gateway;
struct Channel;

/// `source` is not at home elsewhere, and came by a serial port, CAN or another link that is no network, or by the link that it is pinned
/// to. In a network anybody can send in the name of a device.
bool is_known_origin(const Gateway& gateway, const Channel& from, std::uint8_t source);

}    // namespace anogate
