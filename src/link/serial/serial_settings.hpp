// The settings of a serial port.
#pragma once
#include <link/v7_settings.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

enum class Parity : std::uint8_t { none, even, odd };
/// Whether sending is limited to the rate of the serial line.
enum class Pace : std::uint8_t {
    automatic,    // on, except for drivers that ignore the rate (cdc_acm)
    on,
    off,
};
enum class FlowControl : std::uint8_t { none, hardware };

struct SerialSettings {
    std::string device;
    std::uint32_t baud = 500000;    // any integer rate that the driver supports
    Parity parity = Parity::none;
    std::uint8_t stop_bits = 1;    // 1 or 2
    FlowControl flow = FlowControl::none;
    bool low_latency = true;
    Pace pace = Pace::automatic;
    std::optional<bool> dtr;    // std::nullopt: left as the driver sets it
    std::optional<bool> rts;
    V7LinkSettings v7{};
    bool operator==(const SerialSettings&) const = default;
};

}    // namespace anogate
