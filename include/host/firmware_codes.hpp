// The codes of a firmware upgrade (0xF0 with iap_cmd 0; protocol text, section 4).
#pragma once
#include <cstdint>

namespace ano::host::firmware_code {

inline constexpr std::uint16_t info_refused = 0x0101;
inline constexpr std::uint16_t info_accepted = 0x0102;
inline constexpr std::uint16_t erase = 0x0110;
inline constexpr std::uint16_t erase_failed = 0x0111;
inline constexpr std::uint16_t erased = 0x0112;
inline constexpr std::uint16_t frame_failed = 0x1001;
inline constexpr std::uint16_t frame_written = 0x1002;
inline constexpr std::uint16_t all_sent = 0x1010;
inline constexpr std::uint16_t check_failed = 0x1011;
inline constexpr std::uint16_t check_passed = 0x1012;

}    // namespace ano::host::firmware_code
