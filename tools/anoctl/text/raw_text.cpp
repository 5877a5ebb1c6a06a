#include "raw_text.hpp"

#include "frame_printer.hpp"

#include <ano_json/text.hpp>

#include <algorithm>
#include <cstdio>

namespace anoctl {
namespace {

constexpr std::size_t hex_columns = 16;

// The code point of one valid UTF-8 character.
std::uint32_t code_point(std::string_view character) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(character[i]); };
    std::uint32_t point = character.size() == 1 ? byte(0) : byte(0) & (0x7Fu >> character.size());
    for (std::size_t i = 1; i < character.size(); ++i) point = point << 6 | (byte(i) & 0x3Fu);
    return point;
}

std::string with_time(double time, char direction, const std::string& text) {
    return clock_text(time) + ' ' + direction + ' ' + text;
}

}    // namespace

std::string harmless(std::string_view text) {
    std::string format_line;
    for (std::size_t at = 0; at < text.size(); ++at) {
        if (text[at] == '\t') {
            format_line += "    ";
        } else if (const std::size_t size = ano::control_size(text, at); size > 0) {
            const std::uint32_t point = code_point(text.substr(at, size));
            std::array<char, 16> escaped{};
            std::snprintf(escaped.data(), escaped.size(), point < 0x80 ? "\\x%02X" : "\\u{%04X}", static_cast<unsigned>(point));
            format_line += escaped.data();
            at += size - 1;
        } else {
            format_line += text[at];
        }
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
