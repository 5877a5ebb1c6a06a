#include <sys/random.hpp>

#include <sys/random.h>
#include <sys/types.h>

#include <cstdint>

namespace anogate {
namespace {

bool fill(void* to, std::size_t size) { return ::getrandom(to, size, 0) == static_cast<ssize_t>(size); }

}    // namespace

std::optional<std::string> random_hex(std::size_t bytes) {
    std::string raw(bytes, '\0'), text;
    if (!fill(raw.data(), raw.size())) return std::nullopt;
    constexpr char digits[] = "0123456789abcdef";
    for (const char c : raw) {
        const auto byte = static_cast<unsigned char>(c);
        text.append({digits[byte >> 4], digits[byte & 15]});
    }
    return text;
}

std::optional<std::string> random_digits(std::size_t count) {
    std::uint32_t numbers = 1, drawn = 0;
    for (std::size_t i = 0; i < count; ++i) numbers *= 10;
    const std::uint32_t even = UINT32_MAX - UINT32_MAX % numbers;    // larger values would make the first numbers more likely
    do {
        if (!fill(&drawn, sizeof drawn)) return std::nullopt;
    } while (drawn >= even);
    const std::string text = std::to_string(drawn % numbers);
    return std::string(count - text.size(), '0') + text;
}

}    // namespace anogate
