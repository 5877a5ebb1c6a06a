#include <ano_json/text.hpp>
#include <config/config_error.hpp>

namespace anogate {

namespace {

// One of the two bytes of U+0080 to U+009F in UTF-8: control characters for terminals too.
bool is_c1(const std::string& text, std::size_t i) {
    const auto at = [&text](std::size_t place) { return place < text.size() ? static_cast<unsigned char>(text[place]) : 0; };
    return (at(i) == 0xC2 && at(i + 1) >= 0x80 && at(i + 1) < 0xA0) ||
           (i > 0 && at(i - 1) == 0xC2 && at(i) >= 0x80 && at(i) < 0xA0);
}

}    // namespace

std::string printable(const std::string& text, std::size_t most) {
    constexpr char digits[] = "0123456789abcdef";
    const bool ascii_only = !ano::is_utf8(text);
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        const auto byte = static_cast<unsigned char>(c);
        if (result.size() >= most && (ascii_only || byte >> 6 != 2)) return result + "...";    // never inside a character
        const bool control = byte < 0x20 || byte == 0x7F || is_c1(text, i);
        if (!control && (byte < 0x80 || !ascii_only)) result += c;
        else result += {'\\', 'x', digits[byte >> 4], digits[byte & 15]};
    }
    return result;
}

std::string lines(const ConfigErrors& errors) {
    constexpr std::size_t longest = 1000;
    std::string result;
    for (const ConfigError& error : errors) {
        result += "anogated: ";
        if (!error.where.empty()) result += printable(error.where, longest) + ": ";
        result += printable(error.what, longest) + "\n";
    }
    return result;
}

}    // namespace anogate
