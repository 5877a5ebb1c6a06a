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
/// The same for bytes that should be UTF-8; it throws nothing.
std::string valid_utf8(std::string_view bytes);
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

/// The code point of a whole character in UTF-8.
std::uint32_t code_point(std::string_view character) noexcept;

/// The bytes of the character that begins at text[at], if it is one that controls a terminal, reorders text or can't be seen: by Unicode a
/// control (C1 too), a format (U+202E, U+200B), a separator of lines, or ignorable (U+FE0F, U+3164), and U+2800; 0: none begins there.
std::size_t control_size(std::string_view text, std::size_t at) noexcept;

/// In quotation marks, for people to read: control characters are escaped, and of a long text the first 200 bytes are shown.
std::string in_quotes(std::string_view text, char mark = '\'');

}    // namespace ano
