// Parses bytes written as hex digits: "AB FE", "abfe", "0xAB, 0xFE", "0xABFE".
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Reads pairs of hex digits, with or without 0x, separated by white space, commas or nothing. A single digit after 0x is a byte
/// as well. Skips a UTF-8 byte order mark at the beginning. The text may arrive in pieces.
class HexText {
public:
    /// Appends the bytes of `text` to `bytes`. False: a part is not hex text; the bytes before it were appended.
    bool read(std::string_view text, std::vector<std::uint8_t>& bytes);
    /// To be called at the end of the text. False: it ends within a byte.
    bool finish(std::vector<std::uint8_t>& bytes);
    /// The current line, from 1.
    std::size_t line() const noexcept { return line_; }

private:
    bool read(char c, std::vector<std::uint8_t>& bytes);
    bool end_word(std::vector<std::uint8_t>& bytes);

    std::size_t mark_ = 0;      // number of bytes of a UTF-8 byte order mark read so far
    int high_ = -1;             // first digit of an incomplete pair; -1: none
    std::size_t digits_ = 0;    // in this word so far
    bool prefixed_ = false;     // this word began with 0x
    std::size_t line_ = 1;
};

/// The bytes of `text`; std::nullopt if it is not hex text.
std::optional<std::vector<std::uint8_t>> from_hex_text(std::string_view text);

/// Input that is raw bytes or hex text. It is hex text if it contains nothing else; this is decided at the end, or after the text
/// of AB and 7 more bytes. Raw bytes with a frame are never read as text, because 0xAB is not a character of hex text.
class BytesOrText {
public:
    /// The bytes of `piece`, after those that were kept until the type of input was known.
    std::span<const std::uint8_t> read(std::span<const std::uint8_t> piece);
    /// To be called at the end of the input. Returns the bytes still kept.
    std::span<const std::uint8_t> finish();
    /// The line in which hex text ended and other text began; 0: none.
    std::size_t bad_line() const noexcept { return bad_line_; }
    /// The line that is not hex text, so that the input was read as raw bytes; 0: the input is hex text, or not text.
    std::size_t raw_line() const noexcept { return raw_line_; }

private:
    enum class Kind { unknown, raw, text };

    std::span<const std::uint8_t> all_raw();

    Kind kind_ = Kind::unknown;
    HexText text_;
    std::vector<std::uint8_t> held_;     // input as received, until its type is known
    std::vector<std::uint8_t> bytes_;    // bytes of the text
    std::size_t bad_line_ = 0;
    std::size_t raw_line_ = 0;
};

}    // namespace anoctl
