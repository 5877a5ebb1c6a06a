// CRC-16 in the kinds that a loader may use: the protocol text does not say which.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace ano::host {

enum class Crc16 : std::uint8_t { ibm_3740, xmodem, kermit, modbus, arc };

struct Crc16Kind {
    std::string_view name;    // as catalogues and the configuration have it
    std::uint16_t polynomial;
    std::uint16_t first;
    bool reflected;
};
inline constexpr std::array<Crc16Kind, 5> crc16_kinds{{{"crc16/ibm-3740", 0x1021, 0xFFFF, false},
                                                       {"xmodem", 0x1021, 0, false},
                                                       {"kermit", 0x1021, 0, true},
                                                       {"modbus", 0x8005, 0xFFFF, true},
                                                       {"arc", 0x8005, 0, true}}};

constexpr std::string_view name_of(Crc16 kind) noexcept { return crc16_kinds[static_cast<std::size_t>(kind)].name; }
std::optional<Crc16> crc16_called(std::string_view name) noexcept;

/// The CRC over `bytes`.
std::uint16_t crc16_of(Crc16 kind, std::span<const std::uint8_t> bytes) noexcept;

}    // namespace ano::host
