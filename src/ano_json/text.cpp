#include <ano_json/escapes.hpp>
#include <ano_json/shown_text.hpp>
#include <ano_json/text.hpp>

#include <iconv.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace ano {
namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";    // U+FFFD

struct CodePoints {
    std::uint32_t first, last;
};

// Unicode 15: all code points of the categories Cc (controls), Cf (formats), Zl and Zp (separators of lines and paragraphs),
// those with the property Default_Ignorable_Code_Point, assigned or not, and U+2800, which is displayed as a blank. ASCII is not
// included.
constexpr auto invisible = std::to_array<CodePoints>({
    {0x0080, 0x009F},   {0x00AD, 0x00AD},   {0x034F, 0x034F},   {0x0600, 0x0605},   {0x061C, 0x061C},   {0x06DD, 0x06DD},
    {0x070F, 0x070F},   {0x0890, 0x0891},   {0x08E2, 0x08E2},   {0x115F, 0x1160},   {0x17B4, 0x17B5},   {0x180B, 0x180F},
    {0x200B, 0x200F},   {0x2028, 0x202E},   {0x2060, 0x206F},   {0x2800, 0x2800},   {0x3164, 0x3164},   {0xFE00, 0xFE0F},
    {0xFEFF, 0xFEFF},   {0xFFA0, 0xFFA0},   {0xFFF0, 0xFFFB},   {0x110BD, 0x110BD}, {0x110CD, 0x110CD}, {0x13430, 0x1343F},
    {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE0FFF},
});

// The size of the UTF-8 character at the beginning of `text`; 0: there is none. `bad` is then the number of bytes that can't be
// the beginning of another character.
std::size_t utf8_length(std::string_view text, std::size_t& bad) {
    const auto at = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
    bad = 1;
    const std::uint8_t first = at(0);
    if (first < 0x80) return 1;
    if (first < 0xC2 || first > 0xF4) return 0;
    const std::size_t length = first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    // Overlong forms, surrogates and numbers above U+10FFFF are recognised by the second byte.
    std::uint8_t low = 0x80;
    std::uint8_t high = 0xBF;
    if (first == 0xE0) low = 0xA0;
    if (first == 0xED) high = 0x9F;
    if (first == 0xF0) low = 0x90;
    if (first == 0xF4) high = 0x8F;
    for (std::size_t i = 1; i < length; ++i) {
        if (i == text.size() || at(i) < low || at(i) > high) return 0;
        bad = i + 1;
        low = 0x80;
        high = 0xBF;
    }
    return length;
}

constexpr bool is_gbk_lead(char c) noexcept {
    return static_cast<std::uint8_t>(c) > 0x80 && static_cast<std::uint8_t>(c) != 0xFF;
}
constexpr bool is_gbk_trail(char c) noexcept {
    return static_cast<std::uint8_t>(c) >= 0x40 && static_cast<std::uint8_t>(c) != 0x7F && static_cast<std::uint8_t>(c) != 0xFF;
}

class Converter {
public:
    Converter(const char* to, const char* from) : handle_{iconv_open(to, from)} {
        if (failed()) throw std::runtime_error("this system can't convert GBK text (on Debian: libc-gconv-modules-extra)");
    }
    ~Converter() { iconv_close(handle_); }
    Converter(const Converter&) = delete;
    Converter& operator=(const Converter&) = delete;

    // Appends the convertible beginning of `in` to `out` and removes it from `in`. False: the rest of `in` begins with bytes that
    // can't be converted.
    bool convert(std::string_view& in, std::string& out) {
        while (true) {
            std::array<char, 512> room;
            char* from = const_cast<char*>(in.data());    // iconv does not write to it
            std::size_t left = in.size();
            char* to = room.data();
            std::size_t free = room.size();
            const bool done = iconv(handle_, &from, &left, &to, &free) != static_cast<std::size_t>(-1);
            const int error = errno;
            out.append(room.data(), room.size() - free);
            in.remove_prefix(in.size() - left);
            if (done) return true;
            if (error != E2BIG) return false;
        }
    }

private:
    bool failed() const { return reinterpret_cast<std::intptr_t>(handle_) == -1; }
    iconv_t handle_;
};

// True: the text is not UTF-8, and all of it is GBK. A text whose last character is truncated, as in a field of fixed size, is
// still UTF-8 if it has other characters of several bytes.
bool looks_like_gbk(std::string_view text) {
    bool has_others = false;
    std::string_view rest = text;
    std::size_t bad = 0;
    while (!rest.empty()) {
        const std::size_t length = utf8_length(rest, bad);
        if (length == 0) break;
        has_others = has_others || length > 1;
        rest.remove_prefix(length);
    }
    if (rest.empty() || (has_others && bad == rest.size())) return false;
    try {
        std::string out;
        return Converter{"UTF-8", "GBK"}.convert(text, out);
    } catch (const std::runtime_error&) {
        return false;
    }
}

}    // namespace

std::string to_utf8(std::span<const std::uint8_t> bytes, Encoding encoding) {
    std::string_view in{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    std::string out;
    if (encoding == Encoding::automatic) encoding = looks_like_gbk(in) ? Encoding::gbk : Encoding::utf8;
    if (encoding == Encoding::gbk) {
        Converter converter{"UTF-8", "GBK"};
        while (!converter.convert(in, out)) {
            out += replacement;
            const bool is_pair = in.size() > 1 && is_gbk_lead(in[0]) && is_gbk_trail(in[1]);    // not a character
            in.remove_prefix(is_pair ? 2 : 1);
        }
        return out;
    }
    while (!in.empty()) {
        std::size_t bad = 0;
        const std::size_t length = utf8_length(in, bad);
        out += length > 0 ? in.substr(0, length) : replacement;
        in.remove_prefix(length > 0 ? length : bad);
    }
    return out;
}

std::string valid_utf8(std::string_view bytes) {
    return to_utf8({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, Encoding::utf8);
}

std::optional<std::string> from_utf8(std::string_view text, Encoding encoding) {
    for (std::size_t i = 0, bad = 0; i < text.size();) {
        const std::size_t length = utf8_length(text.substr(i), bad);
        if (length == 0) return std::nullopt;
        i += length;
    }
    if (encoding != Encoding::gbk) return std::string{text};
    std::string out;
    if (!Converter{"GBK", "UTF-8"}.convert(text, out)) return std::nullopt;
    return out;
}

std::optional<Number> parse_number(std::string_view text) {
    const bool minus = text.starts_with('-');
    std::string_view digits = text.substr(minus || text.starts_with('+') ? 1 : 0);
    const bool is_hex = digits.starts_with("0x") || digits.starts_with("0X");
    if (is_hex) digits.remove_prefix(2);
    if (digits.empty() || digits.front() == '-' || digits.front() == '+') return std::nullopt;
    const char* const end = digits.data() + digits.size();

    std::uint64_t whole = 0;
    const auto integer = std::from_chars(digits.data(), end, whole, is_hex ? 16 : 10);
    if (integer.ptr == end && integer.ec == std::errc{}) {
        if (!minus) return Number{whole};
        if (whole <= std::uint64_t{1} << 63) return Number{static_cast<std::int64_t>(0 - whole)};
        return Number{-static_cast<double>(whole)};
    }
    if (is_hex) return std::nullopt;
    double value = 0;
    const auto real = std::from_chars(digits.data(), end, value);
    if (real.ptr != end || real.ec != std::errc{}) return std::nullopt;
    return Number{minus ? -value : value};
}

bool is_utf8(std::string_view text) noexcept {
    for (std::size_t bad = 0; !text.empty();) {
        const std::size_t length = utf8_length(text, bad);
        if (length == 0) return false;
        text.remove_prefix(length);
    }
    return true;
}

bool is_ascii(std::string_view text) noexcept {
    return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<std::uint8_t>(c) < 0x80; });
}

bool may_be_gbk(std::string_view text) noexcept {
    while (!text.empty()) {
        const bool is_pair = is_gbk_lead(text[0]);
        if (!is_pair && static_cast<std::uint8_t>(text[0]) >= 0x80) return false;
        if (is_pair && text.size() > 1 && !is_gbk_trail(text[1])) return false;
        text.remove_prefix(is_pair && text.size() > 1 ? std::size_t{2} : std::size_t{1});
    }
    return true;
}

std::string_view without_cut_character(std::string_view text, Encoding encoding) noexcept {
    if (encoding == Encoding::gbk) {
        std::size_t at = 0;
        while (at < text.size()) {
            const bool is_pair = is_gbk_lead(text[at]);
            if (is_pair && at + 1 == text.size()) break;
            at += is_pair && is_gbk_trail(text[at + 1]) ? std::size_t{2} : std::size_t{1};
        }
        return text.substr(0, at);
    }
    constexpr std::size_t most = 3;    // bytes of an incomplete character
    for (std::size_t n = 1; n <= std::min(most, text.size()); ++n) {
        const std::string_view last = text.substr(text.size() - n);
        if ((static_cast<std::uint8_t>(last[0]) & 0xC0) == 0x80) continue;
        std::size_t bad = 0;
        const bool is_begun = static_cast<std::uint8_t>(last[0]) >= 0xC2 && static_cast<std::uint8_t>(last[0]) <= 0xF4;
        return is_begun && utf8_length(last, bad) == 0 && bad == n ? text.substr(0, text.size() - n) : text;
    }
    return text;
}

std::string display_text(std::string_view text, Encoding encoding) {
    if (encoding == Encoding::automatic) {
        const bool is_gbk = !is_utf8(without_cut_character(text, Encoding::utf8)) && may_be_gbk(text);
        encoding = is_gbk ? Encoding::gbk : Encoding::utf8;
    }
    const auto whole = [&](Encoding of) {
        const std::string_view used = without_cut_character(text, of);
        return to_utf8({reinterpret_cast<const std::uint8_t*>(used.data()), used.size()}, of);
    };
    try {
        return whole(encoding);
    } catch (const std::runtime_error&) {    // this system can't convert GBK
        return whole(Encoding::utf8);
    }
}

std::string number_text(double value) {
    std::array<char, 32> room;
    const auto end = std::to_chars(room.data(), room.data() + room.size(), value).ptr;
    return {room.data(), end};
}

std::string address_text(std::span<const std::uint8_t> ip) {
    std::string text;
    for (const std::uint8_t byte : ip) text += (text.empty() ? "" : ".") + std::to_string(byte);
    return text;
}

double widened(float value) {
    constexpr float whole_below = 0x1p24F;    // integers below this need no conversion
    if (std::abs(value) < whole_below && value == std::trunc(value)) return static_cast<double>(value);
    std::array<char, 32> room;
    const auto end = std::to_chars(room.data(), room.data() + room.size(), value).ptr;
    double wide = 0;
    std::from_chars(room.data(), end, wide);
    return static_cast<float>(wide) == value ? wide : static_cast<double>(value);
}

std::uint32_t code_point(std::string_view character) noexcept {
    const auto byte = [&](std::size_t i) { return std::uint32_t{static_cast<std::uint8_t>(character[i])}; };
    if (character.size() == 1) return byte(0);
    std::uint32_t code = byte(0) & (0xFFu >> (character.size() + 1));
    for (std::size_t i = 1; i < character.size(); ++i) code = code << 6 | (byte(i) & 0x3Fu);
    return code;
}

std::size_t control_size(std::string_view text, std::size_t at) noexcept {
    const auto first = static_cast<std::uint8_t>(text[at]);
    if (first < 0x80) return first < 0x20 || first == 0x7F ? 1 : 0;
    std::size_t bad = 0;
    const std::size_t size = utf8_length(text.substr(at), bad);
    if (size == 0) return 0;
    const std::uint32_t code = code_point(text.substr(at, size));
    const auto range = std::partition_point(invisible.begin(), invisible.end(),
                                            [&](const CodePoints& r) { return r.last < code; });
    return range != invisible.end() && range->first <= code ? size : 0;
}

std::string in_quotes(std::string_view text, char mark) {
    constexpr std::size_t shown = 200;
    const std::string valid = valid_utf8(text);
    std::string out(1, mark);
    for (std::size_t i = 0; i < valid.size(); ++i) {
        if (i >= shown && (static_cast<std::uint8_t>(valid[i]) & 0xC0) != 0x80) {    // not inside a character
            out += "...";
            break;
        }
        if (const std::size_t size = control_size(valid, i); size > 0) {
            out += with_escapes(std::string_view{valid}.substr(i, size));
            i += size - 1;
        } else if (valid[i] == mark || valid[i] == '\\') {
            out += {'\\', valid[i]};
        } else {
            out += valid[i];
        }
    }
    return out + mark;
}

}    // namespace ano
