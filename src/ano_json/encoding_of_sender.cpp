#include <ano/reading.hpp>
#include <ano_json/encoding_of_sender.hpp>

#include <cstdint>
#include <variant>

namespace ano {
namespace {

enum class Letters : std::uint8_t { ascii, only_utf8, both, both_and_ascii };

// `utf8` is valid UTF-8. The first byte of characters of level 1 of GB 2312, the 3,755 common ones, is 0xB0 to 0xD7.
Letters letters_in(std::string_view utf8) noexcept {
    bool has_ascii = false, has_pairs = false;
    while (!utf8.empty()) {
        const auto first = static_cast<std::uint8_t>(utf8[0]);
        if (first < 0x80) {
            has_ascii = has_ascii || (first >= 'A' && first <= 'Z') || (first >= 'a' && first <= 'z');
            utf8.remove_prefix(1);
            continue;
        }
        constexpr std::uint8_t first_trail = 0xA1, last_lead = 0xD7;
        if (first > last_lead || utf8.size() < 2 || static_cast<std::uint8_t>(utf8[1]) < first_trail) return Letters::only_utf8;
        constexpr std::uint8_t of_symbols = 0xC2;    // ° ± ² are used in units, and are not letters
        has_pairs = has_pairs || first != of_symbols;
        utf8.remove_prefix(2);
    }
    if (!has_pairs) return Letters::ascii;
    return has_ascii ? Letters::both_and_ascii : Letters::both;
}

}    // namespace

void EncodingOfSender::learn(std::string_view text) noexcept {
    if (has_gbk_) return;
    const std::string_view whole = without_cut_character(text, Encoding::utf8);
    if (!is_utf8(whole)) {
        has_gbk_ = may_be_gbk(text);
        return;
    }
    const Letters letters = letters_in(whole);
    has_utf8_ = has_utf8_ || letters == Letters::only_utf8;
    has_both_ = has_both_ || letters == Letters::both;
    has_both_with_ascii_ = has_both_with_ascii_ || letters == Letters::both_and_ascii;
}

void EncodingOfSender::learn(FrameView frame) noexcept {
    if (has_gbk_) return;
    const Reading reading = read(frame);
    if (!reading) return;
    for (const Field& field : reading.fields())
        if (field.type == Type::text) learn(std::get<std::string_view>(reading.value(field)));
}

}    // namespace ano
