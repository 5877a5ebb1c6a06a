#include <record/recording.hpp>

#include <array>
#include <charconv>

namespace anogate {

std::string_view text_that_fits(std::string_view text) noexcept {
    text = text.substr(0, text.find('\0'));
    if (text.size() <= max_recorded_text) return text;
    std::size_t size = max_recorded_text;
    while (size > 0 && (static_cast<std::uint8_t>(text[size]) & 0xC0) == 0x80) --size;
    return text.substr(0, size);
}

double json_seconds(std::uint64_t ns) noexcept {
    const std::uint64_t microseconds = ns / 1000;
    return static_cast<double>(microseconds) / 1e6;
}

void append_seconds(std::uint64_t ns, std::string& out) {
    constexpr std::uint64_t second = 1'000'000'000;
    std::array<char, 24> text;
    char* const end = text.data() + text.size();
    out.append(text.data(), std::to_chars(text.data(), end, ns / second).ptr);
    const std::size_t point = out.size();
    out.append(text.data(), std::to_chars(text.data(), end, second + ns % second).ptr);    // a 1 keeps the zeros
    out[point] = '.';
}

}    // namespace anogate
