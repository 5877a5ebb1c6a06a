#include <http/client/percent_encoded.hpp>

namespace anogate::http {

std::string percent_encoded(std::string_view word) {
    std::string text;
    for (const char c : word) {
        const auto byte = static_cast<unsigned char>(c);
        const bool is_plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' ||
                              c == '_' || c == '.' || c == '~';
        if (is_plain) text += c;
        else text.append("%").append(1, "0123456789ABCDEF"[byte >> 4]).append(1, "0123456789ABCDEF"[byte & 15]);
    }
    return text;
}

}    // namespace anogate::http
