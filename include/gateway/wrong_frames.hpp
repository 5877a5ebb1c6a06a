// Classifies bytes without valid frames: frames with one certain mistake that the user can correct, or text.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace anogate {

enum class WrongFrames : std::uint8_t {
    none,                 // nothing was recognised
    swapped_checks,       // the additional check is sent before the sum check
    one_byte_length,      // LEN has no high byte
    big_endian_length,    // the high byte of LEN is sent first
    old_body,             // HEAD D_ADDR ID LEN(one byte) DATA SC AC, as in V7, but HEAD is 0xAB
    text,
};

/// The mistake of several frames in `bytes`, which may begin and end inside a frame. Only the first 64 headers are examined.
WrongFrames find_wrong_frames(std::span<const std::uint8_t> bytes) noexcept;

/// Converts text in UTF-8 or GBK; empty: not possible.
using ToUtf8 = std::string (*)(std::span<const std::uint8_t> text);

/// The first characters of a line of text, for display. Control characters are escaped; without `to_utf8` so are all that are not
/// ASCII.
std::string first_characters(std::span<const std::uint8_t> text, ToUtf8 to_utf8 = nullptr);

}    // namespace anogate
