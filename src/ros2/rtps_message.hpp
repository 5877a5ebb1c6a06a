// The structure of the datagrams of DDS (RTPS 2.5, section 8.3). No I/O.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace anogate {

/// The size of the part of a datagram that may be passed to a DDS library: the header and the submessages after it, up to the first one that
/// is incomplete, too short for its kind, or of a vendor's own kind. 0: nothing may be passed. Such submessages, which anyone in the network
/// can send, end a program with Fast DDS 2.9 by assertions.
std::size_t valid_part(std::span<const std::uint8_t> datagram) noexcept;

}    // namespace anogate
