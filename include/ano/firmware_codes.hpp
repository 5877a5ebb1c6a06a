// The two-byte codes of a firmware upgrade (0xF0 with iap_cmd 0; protocol text, section 4). Some devices send and expect them low
// byte first, like all other numbers. Others use high byte first, as in the protocol text.
#pragma once
#include <ano/typed.hpp>

#include <cstdint>
#include <optional>

namespace ano {
namespace firmware_code {

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

}    // namespace firmware_code

/// A received code. A code that is none of the above in either order is read in little-endian order.
struct FirmwareCode {
    std::uint16_t code = 0;
    ByteOrder order = ByteOrder::little;    // also `little` for a code that is equal in both orders
    bool is_of_frame = false;               // "frame failed" and "frame written"
    std::uint16_t frame_num = 0;
};

/// The code in a frame, in either byte order; std::nullopt: the frame has none. One frame is enough to determine the order: the
/// bytes 01 10 and 10 01 are "erase" in one order and "frame failed" in the other, but only the latter has a frame number.
constexpr std::optional<FirmwareCode> firmware_code_in(FrameView frame) noexcept {
    constexpr auto little = ByteOrder::little, big = ByteOrder::big;
    if (const auto view = as<"firmware">(frame)) return FirmwareCode{view->get<"code">(), little, false, 0};
    if (const auto view = as<"firmware", "written">(frame))
        return FirmwareCode{view->get<"code">(), little, true, view->get<"frame_num">()};
    if (const auto view = as<"firmware", "reading">(frame)) return FirmwareCode{view->get<"code">(), big, false, 0};
    if (const auto view = as<"firmware", "reading_check">(frame)) return FirmwareCode{view->get<"code">(), big, false, 0};
    if (const auto view = as<"firmware", "reading_written">(frame))
        return FirmwareCode{view->get<"code">(), big, true, view->get<"frame_num">()};
    return std::nullopt;
}

/// The message with `code` in that byte order; not for codes with a frame number.
inline Draft<"firmware"> firmware_step(std::uint16_t code, ByteOrder order) noexcept {
    Draft<"firmware"> draft;
    const auto swapped = static_cast<std::uint16_t>(code << 8 | code >> 8);
    static_cast<void>(draft.set<"code">(order == ByteOrder::big ? swapped : code));    // a u16 fits
    return draft;
}

}    // namespace ano
