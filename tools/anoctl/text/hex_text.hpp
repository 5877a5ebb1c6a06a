// Bytes as people write them: "AB FE", "abfe", "0xAB, 0xFE", "0xABFE".
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Reads hex digits in pairs, 0x before them or not, with white space or commas between bytes; a single digit behind 0x is
/// a byte as well. A UTF-8 byte order mark before all of it is skipped. Takes text in pieces.
class HexText {
public:
    /// Appends the bytes of `text` to `bytes`. False: part of it is not hex text; the bytes before that part were appended.
    bool read(std::string_view text, std::vector<std::uint8_t>& bytes);
    /// The end of the text. False: half a byte is left.
    bool finish(std::vector<std::uint8_t>& bytes);
    /// The line that is being read, from 1.
    std::size_t line() const noexcept { return line_; }

private:
    bool read(char c, std::vector<std::uint8_t>& bytes);
    bool end_word(std::vector<std::uint8_t>& bytes);

    std::size_t mark_ = 0;      // bytes read so far of a UTF-8 byte order mark
    int high_ = -1;             // the first digit of an incomplete pair; -1: none
    std::size_t digits_ = 0;    // in this word so far
    bool prefixed_ = false;     // this word began with 0x
    std::size_t line_ = 1;
};

/// The bytes of `text`; std::nullopt when it is not hex text.
std::optional<std::vector<std::uint8_t>> from_hex_text(std::string_view text);

/// Input that is raw bytes or hex text. It is hex text when it contains nothing else, which is known at the end, or after the
/// text of AB and 7 more bytes. Raw bytes with a frame are never taken for text, since 0xAB is not a character of hex text.
class BytesOrText {
public:
    /// The bytes of `piece`, after those that were held back while it was not known what the input is.
    std::span<const std::uint8_t> read(std::span<const std::uint8_t> piece);
    /// The end of the input: the bytes that were still held back.
    std::span<const std::uint8_t> finish();
    /// The line in which hex text ended and something else began; 0: it did not.
    std::size_t bad_line() const noexcept { return bad_line_; }
    /// The line in which text turned out not to be hex text, so that it was read as raw bytes; 0: it is hex text, or not text.
    std::size_t raw_line() const noexcept { return raw_line_; }

private:
    enum class Kind { unknown, raw, text };

    std::span<const std::uint8_t> all_raw();

    Kind kind_ = Kind::unknown;
    HexText text_;
    std::vector<std::uint8_t> held_;     // as it came, while it is not known what the input is
    std::vector<std::uint8_t> bytes_;    // the bytes of the text
    std::size_t bad_line_ = 0;
    std::size_t raw_line_ = 0;
};

}    // namespace anoctl
