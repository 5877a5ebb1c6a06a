// The settings of a CAN interface. They are here because can_stream.hpp needs them.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

enum class CanFraming : std::uint8_t { stream, isotp };

struct CanSettings {
    std::string interface;
    CanFraming framing = CanFraming::stream;
    bool fd = false;                      // CAN FD frames; the interface must support them
    bool brs = true;                      // send their data at the faster bit rate
    bool extended = false;                // 29-bit ids
    std::optional<std::uint32_t> base;    // of the ids of stream framing; std::nullopt: 0x600, or 0x0AB00000 when extended
    std::optional<std::uint32_t> tx;      // the ids of ISO-TP, which needs both
    std::optional<std::uint32_t> rx;
    bool operator==(const CanSettings&) const = default;
};

}    // namespace anogate
