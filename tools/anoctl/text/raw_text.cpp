#include "raw_text.hpp"

#include "frame_printer.hpp"

#include <algorithm>
#include <cstdio>

namespace anoctl {
namespace {

constexpr std::size_t hex_columns = 16;

// The code point at text[at] (UTF-8), and its size in bytes.
std::pair<std::uint32_t, std::size_t> code_point(std::string_view text, std::size_t at) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[at + i]); };
    const std::uint8_t first = byte(0);
    const std::size_t size = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    if (at + size > text.size()) return {first, 1};
    std::uint32_t point = size == 1 ? first : first & (0x7Fu >> size);
    for (std::size_t i = 1; i < size; ++i) point = point << 6 | (byte(i) & 0x3Fu);
    return {point, size};
}

// Control characters (C0, C1) and Unicode format characters: direction, joiners, separators, tags.
bool is_harmful(std::uint32_t point) {
    const auto in = [point](std::uint32_t first, std::uint32_t last) { return first <= point && point <= last; };
    return point < 0x20 || in(0x7F, 0x9F) || point == 0xAD || point == 0x34F || point == 0x61C || in(0x115F, 0x1160) ||
           point == 0x2800 || point == 0x3164 || point == 0xFFA0 || point == 0x180E || in(0x200B, 0x200F) || in(0x2028, 0x202E) ||
           in(0x2060, 0x206F) || point == 0xFEFF || in(0xFFF9, 0xFFFB) || in(0xE0000, 0xE0FFF);
}

std::string with_time(double time, char direction, const std::string& text) {
    return clock_text(time) + ' ' + direction + ' ' + text;
}

}    // namespace

std::string harmless(std::string_view text) {
    std::string format_line;
    for (std::size_t at = 0; at < text.size();) {
        const auto [point, size] = code_point(text, at);
        if (point == '\t') {
            format_line += "    ";
        } else if (is_harmful(point)) {
            std::array<char, 16> escaped{};
            std::snprintf(escaped.data(), escaped.size(), point < 0x80 ? "\\x%02X" : "\\u{%04X}", static_cast<unsigned>(point));
            format_line += escaped.data();
        } else {
            format_line.append(text, at, size);
        }
        at += size;
    }
    return format_line;
}

std::vector<std::string> RawText::add(char direction, double time, std::string_view bytes, ano::TimePoint now) {
    std::vector<std::string> whole;
    if (options_.hex) {
        add_hex(direction, time, bytes, whole);
        return whole;
    }
    Line& line = lines_[direction == '<' ? 0 : 1];
    for (const char c : bytes) {
        const bool joined = c == '\n' && line.after_return;
        line.after_return = c == '\r';
        if (joined) continue;
        if (line.bytes.empty()) line.time = time;
        line.since = now;
        if (c != '\n' && c != '\r') line.bytes += c;
        // A long line is broken, but not within a multibyte character; in GBK its second byte may be ASCII, from 0x30 on.
        const bool is_long = line.bytes.size() >= max_line &&
                             (static_cast<std::uint8_t>(c) < 0x30 || line.bytes.size() >= 2 * max_line);
        if (c != '\n' && c != '\r' && !is_long) continue;
        whole.push_back(format_line(direction, line));
        line.bytes.clear();
    }
    return whole;
}

std::optional<ano::TimePoint> RawText::due() const noexcept {
    std::optional<ano::TimePoint> first;
    for (const Line& line : lines_)
        if (!line.bytes.empty()) first = std::min(first.value_or(ano::TimePoint::max()), line.since + patience);
    return first;
}

std::vector<std::string> RawText::expire(ano::TimePoint now) {
    std::vector<std::string> displayed;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        if (lines_[i].bytes.empty() || now < lines_[i].since + patience) continue;
        displayed.push_back(format_line(i == 0 ? '<' : '>', lines_[i]));
        lines_[i].bytes.clear();
    }
    return displayed;
}

void RawText::add_hex(char direction, double time, std::string_view bytes, std::vector<std::string>& lines) const {
    for (std::size_t at = 0; at < bytes.size(); at += hex_columns) {
        std::string digits, text;
        for (std::size_t i = 0; i < hex_columns; ++i) {
            if (at + i >= bytes.size()) {
                digits += "   ";
                continue;
            }
            const auto byte = static_cast<std::uint8_t>(bytes[at + i]);
            digits.append(1, "0123456789ABCDEF"[byte >> 4]).append(1, "0123456789ABCDEF"[byte & 15]).append(1, ' ');
            text += byte >= 0x20 && byte < 0x7F ? bytes[at + i] : '.';
        }
        lines.push_back(with_time(time, direction, digits + ' ' + text));
    }
}

std::string RawText::format_line(char direction, const Line& line) const {
    const std::span<const std::uint8_t> bytes{reinterpret_cast<const std::uint8_t*>(line.bytes.data()), line.bytes.size()};
    return with_time(line.time, direction, harmless(ano::to_utf8(bytes, options_.encoding)));
}

}    // namespace anoctl
