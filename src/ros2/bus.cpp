#include <ros2/bus.hpp>

namespace anogate {

std::string format_guid(const Guid& guid) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const std::uint8_t byte : guid) {
        if (!text.empty()) text += '.';
        text += digits[byte >> 4];
        text += digits[byte & 15];
    }
    return text;
}

}    // namespace anogate
