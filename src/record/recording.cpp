#include <record/recording.hpp>

#include <array>
#include <cstdio>

namespace anogate {

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
