// Converts text and numbers between the wire, JSON and texts for the user.
#pragma once
#include <ano/wire.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ano {

/// The encoding of text on the wire.
enum class Encoding : std::uint8_t {
    utf8,
    gbk,
    automatic,    // read as GBK where it is valid GBK and not valid UTF-8, otherwise as UTF-8; written as UTF-8
};

/// Valid UTF-8, with U+FFFD for bytes that are not text in `encoding`. Throws std::runtime_error when the system can't convert
/// it (`automatic` takes it for UTF-8 then).
std::string to_utf8(std::span<const std::uint8_t> bytes, Encoding encoding);
/// `text` in `encoding`; std::nullopt when it is not UTF-8 or has characters that `encoding` lacks. Throws as to_utf8() does.
std::optional<std::string> from_utf8(std::string_view text, Encoding encoding);

bool is_utf8(std::string_view text) noexcept;
bool is_ascii(std::string_view text) noexcept;

/// A number as it is written in C: -1.5, 1e-7, 0xDC; also nan and inf. A leading 0 is decimal. std::nullopt for
/// anything else.
std::optional<Number> parse_number(std::string_view text);
/// The shortest text that reads as `value` again.
std::string number_text(double value);
/// "192.168.0.1"
std::string address_text(std::span<const std::uint8_t> ip);
/// The double that prints as `value` does: 0.1 for 0.1f. It is `value` again as a float.
double widened(float value);

/// The bytes of the control character that begins at text[at], of which terminals obey U+0080 to U+009F too, or of the character that
/// reorders text or has no width (U+202E, U+200B), or is drawn as a blank but is none (U+3164, U+2800); 0: none begins there.
std::size_t control_size(std::string_view text, std::size_t at) noexcept;

/// In quotation marks, for people to read: control characters are escaped, and of a long text the first 200 bytes are shown.
std::string in_quotes(std::string_view text, char mark = '\'');

}    // namespace ano
