#include "table.hpp"

#include <ano_json/text.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <ostream>
#include <utility>

namespace anoctl {
namespace {

/// The character that begins at text[at], and how many bytes it takes; `text` is UTF-8.
std::pair<std::uint32_t, std::size_t> character(std::string_view text, std::size_t at) noexcept {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[at + i]); };
    const std::size_t size = byte(0) < 0x80 ? 1 : byte(0) < 0xE0 ? 2 : byte(0) < 0xF0 ? 3 : 4;
    if (size == 1 || at + size > text.size()) return {byte(0), 1};
    std::uint32_t value = byte(0) & (0xFFu >> (size + 1));
    for (std::size_t i = 1; i < size; ++i) value = value << 6 | (byte(i) & 0x3Fu);
    return {value, size};
}

bool is_wide(std::uint32_t c) noexcept {
    constexpr std::pair<std::uint32_t, std::uint32_t> wide[] = {{0x1100, 0x115F}, {0x2E80, 0xA4CF},   {0xAC00, 0xD7A3},
                                                                {0xF900, 0xFAFF}, {0xFE30, 0xFE6F},   {0xFF00, 0xFF60},
                                                                {0xFFE0, 0xFFE6}, {0x1F300, 0x1FAFF}, {0x20000, 0x3FFFD}};
    return std::any_of(std::begin(wide), std::end(wide),
                       [c](const auto& range) { return range.first <= c && c <= range.second; });
}

void add(std::string& line, const std::string& cell, std::size_t width, bool to_the_right) {
    const std::string space(width - cells_of(cell), ' ');
    line.append(to_the_right ? space + cell : cell + space).append("  ");
}

}    // namespace

std::size_t cells_of(std::string_view text) noexcept {
    std::size_t cells = 0;
    for (std::size_t at = 0; at < text.size();) {
        const auto [c, size] = character(text, at);
        cells += is_wide(c) ? 2u : 1u;
        at += size;
    }
    return cells;
}

std::string without_controls(std::string_view text) {
    std::string all;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t control = ano::control_size(text, at);
        if (control > 0) all += '?';
        else all += text[at];
        at += std::max<std::size_t>(control, 1);
    }
    return all;
}

std::string time_text(double seconds) {
    if (seconds < 10) {
        std::array<char, 16> text{};
        std::snprintf(text.data(), text.size(), "%.1f s", std::max(seconds, 0.0));
        return text.data();
    }
    const auto whole = static_cast<std::uint64_t>(std::min(seconds, 1e15));
    const auto two = [](std::uint64_t large, const char* unit, std::uint64_t small, const char* lesser) {
        return std::to_string(large) + unit + (small == 0 ? "" : " " + std::to_string(small) + lesser);
    };
    if (whole < 120) return std::to_string(whole) + " s";
    if (whole < 3600) return std::to_string(whole / 60) + " min";
    if (whole < 86400) return two(whole / 3600, " h", whole / 60 % 60, " min");
    return two(whole / 86400, " d", whole / 3600 % 24, " h");
}

void Table::write(std::ostream& out, std::string_view indent) const {
    const auto is_numbers = [this](std::size_t column) { return heading_[column].starts_with(' '); };
    std::vector<std::size_t> widths(heading_.size());
    for (const Line& line : lines_)
        for (std::size_t i = 0; line.size() == heading_.size() && i < line.size(); ++i)
            widths[i] = std::max(widths[i], cells_of(line[i]));
    Line heading = heading_;
    for (std::size_t i = 0; i < widths.size(); ++i) {
        heading[i].erase(0, heading[i].find_first_not_of(' '));
        if (widths[i] > 0) widths[i] = std::max(widths[i], cells_of(heading[i]));
    }
    const auto write_line = [&](const Line& line) {
        std::string text{indent};
        if (line.size() != heading_.size()) text += line.front();
        else
            for (std::size_t i = 0; i < line.size(); ++i)
                if (widths[i] > 0) add(text, line[i], widths[i], is_numbers(i));
        out << text.substr(0, text.find_last_not_of(' ') + 1) << '\n';
    };
    write_line(heading);
    for (const Line& line : lines_) write_line(line);
}

}    // namespace anoctl
