#include <ano/frame.hpp>
#include <ano/hex.hpp>
#include <gateway/wrong_frames.hpp>

#include <algorithm>
#include <array>
#include <bitset>
#include <cstddef>

namespace anogate {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr int max_headers = 64;
constexpr int enough_wrong_frames = 3;    // each fits by chance once in 65536 headers
constexpr std::size_t enough_text = 64, max_shown_text = 40;

/// A frame layout: the start and the length of DATA.
struct Layout {
    WrongFrames mistake;
    std::size_t header;
    std::size_t (*length)(const std::uint8_t* header);
    bool is_swapped = false;
};
constexpr Layout layouts[] = {
    {WrongFrames::swapped_checks, 6, [](const std::uint8_t* h) { return ano::data_length(h); }, true},
    {WrongFrames::one_byte_length, 5, [](const std::uint8_t* h) { return std::size_t{h[4]}; }},
    {WrongFrames::big_endian_length, 6, [](const std::uint8_t* h) { return std::size_t{h[4]} << 8 | h[5]; }},
    {WrongFrames::old_body, 4, [](const std::uint8_t* h) { return std::size_t{h[3]}; }},
};

/// The size of a frame with this layout at the beginning of `bytes`; 0: there is none.
std::size_t size_of_frame(const Layout& layout, Bytes bytes) noexcept {
    if (bytes.size() < layout.header + 2) return 0;
    const std::size_t end = layout.header + layout.length(bytes.data());
    if (bytes.size() < end + 2) return 0;
    const ano::Checks checks = ano::checks_of(bytes.first(end));
    const bool holds = layout.is_swapped ? bytes[end] == checks.add && bytes[end + 1] == checks.sum && checks.add != checks.sum
                                         : bytes[end] == checks.sum && bytes[end + 1] == checks.add;
    return holds ? end + 2 : 0;
}

WrongFrames mistake_of_frames(Bytes bytes) noexcept {
    std::array<int, std::size(layouts)> found{};
    std::size_t at = 0;
    for (int headers = 0; headers < max_headers; ++headers) {
        at = static_cast<std::size_t>(std::find(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end(), ano::head) -
                                      bytes.begin());
        if (at == bytes.size()) break;
        std::size_t size = 1;
        for (std::size_t i = 0; i < std::size(layouts); ++i)
            if (const std::size_t fits = size_of_frame(layouts[i], bytes.subspan(at)); fits > 0) {
                size = std::max(size, fits);
                ++found[i];
            }
        at += size;
    }
    const auto most = std::max_element(found.begin(), found.end());
    return *most >= enough_wrong_frames ? layouts[most - found.begin()].mistake : WrongFrames::none;
}

bool is_printable(std::uint8_t byte) noexcept { return byte >= 0x20 && byte < 0x7F; }
bool is_space(std::uint8_t byte) noexcept { return byte == '\r' || byte == '\n' || byte == '\t' || byte == 0x1B; }

bool is_line_end(std::uint8_t byte) noexcept { return byte == '\n' || byte == '\r'; }

// The size of the Chinese character that begins here: three bytes in UTF-8, two in GB 2312; 0: none does.
std::size_t chinese_at(Bytes bytes) noexcept {
    const auto is_within = [&](std::size_t i, std::uint8_t first, std::uint8_t last) {
        return i < bytes.size() && bytes[i] >= first && bytes[i] <= last;
    };
    if (is_within(0, 0xE2, 0xEF) && is_within(1, 0x80, 0xBF) && is_within(2, 0x80, 0xBF)) return 3;
    if ((is_within(0, 0xA1, 0xA3) || is_within(0, 0xB0, 0xF7)) && is_within(1, 0xA1, 0xFE)) return 2;
    return 0;
}

// Almost only ASCII and Chinese characters. The beginning of the first line may be missing.
bool is_chinese_text(Bytes bytes) noexcept {
    const auto begin = std::find_if(bytes.begin(), bytes.end(), is_line_end);
    const auto end = std::find_if(bytes.rbegin(), bytes.rend(), is_line_end).base();
    if (begin >= end) return false;
    const Bytes lines = bytes.subspan(static_cast<std::size_t>(begin - bytes.begin()), static_cast<std::size_t>(end - begin));
    std::size_t readable = 0;
    for (std::size_t i = 0; i < lines.size();) {
        const std::size_t chinese = chinese_at(lines.subspan(i));
        readable += chinese > 0 ? chinese : is_printable(lines[i]) || is_space(lines[i]) ? 1 : 0;
        i += std::max<std::size_t>(chinese, 1);
    }
    return lines.size() >= enough_text / 2 && readable * 10 >= lines.size() * 9;
}

// Lines of ASCII, possibly with some UTF-8 or GBK. A third of random bytes is printable, but an eighth is control characters.
// Without a line end, only printable ASCII counts, of several kinds: a wrong baud rate gives few.
bool is_text(Bytes bytes) noexcept {
    if (bytes.size() < enough_text) return false;
    constexpr std::size_t enough_kinds = 6;
    std::size_t printable = 0, controls = 0, line_ends = 0;
    std::bitset<256> kinds;
    for (const std::uint8_t byte : bytes) {
        printable += is_printable(byte);
        controls += (byte < 0x20 && !is_space(byte)) || byte == 0x7F || byte == 0xFF;
        line_ends += byte == '\n' || byte == '\r';
        kinds.set(byte);
    }
    if (line_ends == 0) return printable == bytes.size() && kinds.count() >= enough_kinds;
    return controls * 100 <= bytes.size() && (printable * 2 >= bytes.size() || is_chinese_text(bytes));
}

// At most max_shown_text characters; `has_utf8`: non-ASCII characters can be displayed.
std::string escaped(Bytes text, bool has_utf8) {
    std::string shown;
    std::size_t characters = 0;
    for (const std::uint8_t byte : text) {
        const bool continues = has_utf8 && byte >= 0x80 && byte < 0xC0;
        if (!continues && (characters >= max_shown_text || (!has_utf8 && shown.size() >= max_shown_text))) break;
        characters += continues ? 0 : 1;
        if (byte == '\n') shown += "\\n";
        else if (byte == '\r') shown += "\\r";
        else if (byte == '\t') shown += "\\t";
        else if ((is_printable(byte) && byte != '\'' && byte != '\\') || (has_utf8 && byte >= 0x80))
            shown += static_cast<char>(byte);
        else shown += "\\x" + ano::hex_byte(byte).substr(2);
    }
    return shown;
}

}    // namespace

WrongFrames find_wrong_frames(Bytes bytes) noexcept {
    const WrongFrames mistake = mistake_of_frames(bytes);
    if (mistake != WrongFrames::none) return mistake;
    return is_text(bytes) ? WrongFrames::text : WrongFrames::none;
}

std::string first_characters(Bytes text, ToUtf8 to_utf8) {
    auto begin = std::find_if(text.begin(), text.end(), is_line_end);    // the beginning of the first line may be missing
    begin = std::find_if_not(begin, text.end(), is_line_end);
    if (begin == text.end()) begin = text.begin();
    // Whole lines, so that no character is cut.
    const auto far = begin + std::min<std::ptrdiff_t>(text.end() - begin, 3 * max_shown_text);
    auto end = std::find_if(far, text.end(), is_line_end);
    if (end == text.end()) end = far;
    const std::string utf8 = to_utf8 != nullptr ? to_utf8(Bytes{begin, end}) : std::string{};
    return utf8.empty() ? escaped(Bytes{begin, text.end()}, false)
                        : escaped({reinterpret_cast<const std::uint8_t*>(utf8.data()), utf8.size()}, true);
}

}    // namespace anogate
