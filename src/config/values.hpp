// Converts single values from and to text. parse_…() returns std::nullopt if the text is not such a value.
#pragma once
#include <ano/time.hpp>
#include <gateway/filter.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// yes, no, true, false, on, off.
std::optional<bool> parse_boolean(std::string_view text);
/// Only decimal digits.
std::optional<std::uint64_t> parse_number(std::string_view text);
/// 2, 0.5 or 0.125, in thousandths.
std::optional<std::uint64_t> parse_thousandths(std::string_view text);
/// A hardware id: 220 or 0xDC.
std::optional<std::uint8_t> parse_address(std::string_view text);
/// Decimal, or hex with 0x.
std::optional<std::uint64_t> parse_can_id(std::string_view text);
std::string can_id_text(std::uint64_t id);

/// 0xDC, 220, 30-40 or 0x1E-0x28; first ≤ last.
std::optional<ByteRange> parse_addresses(std::string_view text);
/// 0xDC, or 30-40.
std::string addresses_text(ByteRange range);
std::string address_text(std::uint8_t address);    // 0xDC

/// A whole number of ms, s, m or h.
std::optional<ano::Duration> parse_duration(std::string_view text);
/// In the largest unit without a fraction; `duration` must be whole milliseconds.
std::string duration_text(ano::Duration duration);

/// Bytes, or a whole number of kB, MB, GB (1000), KiB, MiB, GiB (1024).
std::optional<std::uint64_t> parse_size(std::string_view text);
std::string size_text(std::uint64_t bytes);

}    // namespace anogate
