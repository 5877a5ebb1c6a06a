#include <ano_json/text.hpp>
#include <config/config_error.hpp>

namespace anogate {

std::string printable(const std::string& text, std::size_t most) {
    constexpr char digits[] = "0123456789abcdef";
    const bool ascii_only = !ano::is_utf8(text);
    std::string result;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (result.size() >= most && (ascii_only || byte >> 6 != 2)) return result + "...";    // never inside a character
        if (byte >= 0x20 && byte != 0x7F && (byte < 0x80 || !ascii_only)) result += c;
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
