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
    automatic,    // read as GBK if it is valid GBK and not valid UTF-8, otherwise as UTF-8; written as UTF-8
};

/// Valid UTF-8, with U+FFFD for bytes that are not text in `encoding`. Throws std::runtime_error if the system can't convert it
/// (`automatic` is UTF-8 then).
std::string to_utf8(std::span<const std::uint8_t> bytes, Encoding encoding);
/// The same for bytes that should be UTF-8. Does not throw.
std::string valid_utf8(std::string_view bytes);
/// `text` in `encoding`; std::nullopt: it is not UTF-8, or has characters that are not in `encoding`. Throws like to_utf8().
std::optional<std::string> from_utf8(std::string_view text, Encoding encoding);

bool is_utf8(std::string_view text) noexcept;
bool is_ascii(std::string_view text) noexcept;

/// A number in the notation of C: -1.5, 1e-7, 0xDC; also nan and inf. A leading 0 is decimal. std::nullopt for any other text.
std::optional<Number> parse_number(std::string_view text);
/// The shortest text that is read as `value` again.
std::string number_text(double value);
/// "192.168.0.1"
std::string address_text(std::span<const std::uint8_t> ip);
/// The double with the same decimal text as `value`: 0.1 for 0.1f. Converted to float, it is `value`.
double widened(float value);

/// The code point of a complete character in UTF-8.
std::uint32_t code_point(std::string_view character) noexcept;

/// The size of the character at text[at], if it controls a terminal, reorders text or is invisible: a Unicode control (C1 too), a
/// format (U+202E, U+200B), a line separator, an ignorable (U+FE0F, U+3164), or U+2800. 0: there is none.
std::size_t control_size(std::string_view text, std::size_t at) noexcept;

/// In quotation marks, for display: control characters are escaped, and a long text is truncated to its first 200 bytes.
std::string in_quotes(std::string_view text, char mark = '\'');

}    // namespace ano
