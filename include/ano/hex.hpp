// Bytes as hexadecimal digits.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ano {

/// "ab01", without spaces.
std::string hex(std::span<const std::uint8_t> bytes);
/// "AB 01".
std::string spaced_hex(std::span<const std::uint8_t> bytes);

/// "0xDC": ids and addresses, for people.
std::string hex_byte(std::uint8_t byte);

/// Pairs of digits in upper or lower case, with or without white space between pairs; std::nullopt for any other text.
std::optional<std::vector<std::uint8_t>> from_hex(std::string_view text);

}    // namespace ano
