// How a frame is treated where a line is slow (protocol text, section 5). Which id is treated how, the message table says.
#pragma once
#include <cstddef>
#include <cstdint>

namespace anogate {

/// In the order in which they leave.
enum class TrafficClass : std::uint8_t { urgent, telemetry, bulk };
inline constexpr std::size_t traffic_classes = 3;

/// Which waiting frame of the same source and destination a newer one may replace.
enum class Replace : std::uint8_t {
    never,
    same_id,
    same_id_and_first_byte,    // of DATA
};

/// Which age limit holds for it.
enum class AgeKind : std::uint8_t { control, telemetry, rest };

struct Treatment {
    TrafficClass traffic = TrafficClass::bulk;
    Replace replace = Replace::never;
    AgeKind age = AgeKind::rest;
    friend constexpr bool operator==(Treatment, Treatment) noexcept = default;
};

}  // namespace anogate
