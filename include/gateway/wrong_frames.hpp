// What bytes are in which no frame was found: frames with one certain mistake, which a person can mend, or text.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace anogate {

enum class WrongFrames : std::uint8_t {
    none,                 // nothing is known of them
    swapped_checks,       // the additional check stands before the sum check
    one_byte_length,      // LEN has no high byte
    big_endian_length,    // LEN has its high byte first
    old_body,             // HEAD D_ADDR ID LEN(one byte) DATA SC AC, as in V7, but HEAD is 0xAB
    text,
};

/// The mistake of several frames in `bytes`, which may begin and end inside a frame. Takes time for the first 64 headers at most.
WrongFrames find_wrong_frames(std::span<const std::uint8_t> bytes) noexcept;

/// Converts text in UTF-8 or GBK; empty: it can't.
using ToUtf8 = std::string (*)(std::span<const std::uint8_t> text);

/// The first characters of a line of text, for people: control characters are escaped, and without `to_utf8` all that is not ASCII.
std::string first_characters(std::span<const std::uint8_t> text, ToUtf8 to_utf8 = nullptr);

}    // namespace anogate
