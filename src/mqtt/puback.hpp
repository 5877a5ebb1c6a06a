// What the broker's answer to a published message means for it. No I/O.
#pragma once
#include <cstdint>

namespace anogate {

enum class Fate : std::uint8_t {
    delivered,
    unread,     // accepted, but it has no subscriber
    denied,     // not allowed: it is never published again
    refused,    // invalid or too large for this broker: it is never published again
    wait,       // the broker can't accept it now
};
inline constexpr std::size_t fates = 5;

/// `reason`: the reason code of PUBACK.
constexpr Fate fate_of(std::uint8_t reason) noexcept {
    switch (reason) {
    case 0x10: return Fate::unread;
    case 0x87: return Fate::denied;
    case 0x90:                          // topic name invalid
    case 0x95:                          // packet too large
    case 0x99:                          // payload format invalid
    case 0x9A:                          // retain not supported
    case 0x9B: return Fate::refused;    // QoS not supported
    default: return reason < 0x80 ? Fate::delivered : Fate::wait;
    }
}

}    // namespace anogate
