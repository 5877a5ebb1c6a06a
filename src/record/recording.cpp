#include <record/recording.hpp>

#include <array>
#include <cstdio>

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

std::string seconds_text(std::uint64_t ns) {
    std::array<char, 40> text;
    std::snprintf(text.data(), text.size(), "%llu.%09llu", static_cast<unsigned long long>(ns / 1'000'000'000),
                  static_cast<unsigned long long>(ns % 1'000'000'000));
    return text.data();
}

}    // namespace anogate
