#include <ano_json/text.hpp>
#include <config/config_error.hpp>

namespace anogate {

std::string printable(const std::string& text, std::size_t max_bytes) {
    constexpr char digits[] = "0123456789abcdef";
    const bool ascii_only = !ano::is_utf8(text);
    std::string result;
    std::size_t control_ends = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        if (result.size() >= max_bytes && (ascii_only || byte >> 6 != 2))
            return result + "...";    // never cut inside a character
        if (const std::size_t size = ano::control_size(text, i); size > 0) control_ends = i + size;
        if (i >= control_ends && (byte < 0x80 || !ascii_only)) result += text[i];
        else result += {'\\', 'x', digits[byte >> 4], digits[byte & 15]};
    }
    return result;
}

std::string line_of(const ConfigError& error) {
    constexpr std::size_t max_bytes = 1000;
    return (error.where.empty() ? "" : printable(error.where, max_bytes) + ": ") + printable(error.what, max_bytes);
}

std::string lines(const ConfigErrors& errors) {
    std::string result;
    for (const ConfigError& error : errors) result += "anogated: " + line_of(error) + "\n";
    return result;
}

}    // namespace anogate
