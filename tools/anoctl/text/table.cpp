#include "table.hpp"

#include <ano_json/text.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ostream>
#include <utility>

namespace anoctl {
namespace {

/// The character that begins at text[at] (UTF-8), and its size in bytes.
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

std::string in_cells(std::string_view text, std::size_t cells) {
    std::size_t at = 0, taken = 0;
    while (at < text.size()) {
        const auto [c, size] = character(text, at);
        taken += is_wide(c) ? 2u : 1u;
        if (taken > cells) break;
        at += size;
    }
    return std::string{text.substr(0, at)};
}

std::string cut_line(std::string_view text, std::size_t cells) {
    constexpr std::string_view color_begin = "\x1b[", no_color = "\x1b[0m";
    if (cells == 0) return std::string{text};
    std::string line;
    std::size_t taken = 0, fits = 0;    // cells so far; bytes of `line` that leave a cell for the mark
    bool is_colored = false;
    for (std::size_t at = 0; at < text.size();) {
        if (text.substr(at).starts_with(color_begin)) {
            const std::size_t size = std::min(text.find('m', at), text.size() - 1) + 1 - at;
            is_colored = text.substr(at, size) != no_color;
            line += text.substr(at, size);
            at += size;
            continue;
        }
        const auto [c, size] = character(text, at);
        const std::size_t of_it = is_wide(c) ? 2 : 1;
        if (taken + of_it > cells) {
            line.resize(fits);
            return line + "…" + (is_colored ? std::string{no_color} : std::string{});
        }
        taken += of_it;
        line += text.substr(at, size);
        if (taken < cells) fits = line.size();
        at += size;
    }
    return line;
}

std::string wrapped(std::string_view text, std::size_t width, std::size_t indent, std::size_t begin) {
    if (width == 0) return std::string{text};
    std::string all;
    std::size_t line = 0, cells = begin;      // start of the current line, and its cells so far
    std::size_t end = text.npos, next = 0;    // where the line may be broken
    bool has_word = false;
    for (std::size_t at = 0; at < text.size();) {
        const auto [c, size] = character(text, at);
        const std::size_t its_cells = is_wide(c) ? 2u : 1u;
        if (has_word && (c == ' ' || its_cells == 2)) {
            end = at;
            next = c == ' ' ? at + 1 : at;
        }
        if (c == '\n') {
            all.append(text.substr(line, at + 1 - line));
            line = at + 1;
            cells = 0;
            end = text.npos;
            has_word = false;
        } else if (c != ' ' && cells + its_cells > width && end != text.npos) {
            all.append(text.substr(line, end - line)).append("\n").append(indent, ' ');
            line = next;
            cells = indent + cells_of(text.substr(line, at - line)) + its_cells;
            end = text.npos;
        } else {
            cells += its_cells;
        }
        has_word = has_word || (c != ' ' && c != '\n');
        at += size;
    }
    return all.append(text.substr(line));
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

std::string plural(std::size_t number, const std::string& word) {
    return std::to_string(number) + " " + word + (number == 1 ? "" : "s");
}

std::string time_text(double seconds) {
    if (seconds < 9.95) {
        std::array<char, 16> text{};
        std::snprintf(text.data(), text.size(), "%.1f s", std::max(seconds, 0.0));
        return text.data();
    }
    const auto whole = static_cast<std::uint64_t>(std::llround(std::min(seconds, 1e15)));
    const auto two = [](std::uint64_t large, const char* unit, std::uint64_t small, const char* lesser) {
        return std::to_string(large) + unit + (small == 0 ? "" : " " + std::to_string(small) + lesser);
    };
    if (whole < 120) return std::to_string(whole) + " s";
    if (whole < 3600) return std::to_string(whole / 60) + " min";
    if (whole < 86400) return two(whole / 3600, " h", whole / 60 % 60, " min");
    return two(whole / 86400, " d", whole / 3600 % 24, " h");
}

// The place of a column: the line within its row, the first cell, the number of cells.
struct Table::Column {
    std::size_t number, line, at, width;
    bool is_right;
};

std::vector<Table::Column> Table::columns(std::size_t indent, std::size_t width) const {
    constexpr std::size_t min_cells = 16;    // narrower text is hard to read
    std::vector<Column> all;
    std::size_t at = indent, line = 0;
    for (std::size_t i = 0; i < heading_.size(); ++i) {
        std::size_t cells = 0;
        for (const Line& row : lines_)
            if (row.size() == heading_.size()) cells = std::max(cells, cells_of(row[i]));
        const bool is_right = heading_[i].starts_with(' ');
        if (cells == 0) continue;
        cells = std::max(cells, cells_of(heading_[i]) - (is_right ? 1u : 0u));
        const bool may_shrink = i + 1 == heading_.size() && !is_right;
        const auto room = [&] { return width - std::min(width, at); };
        const bool fits = width == 0 || cells <= room() || (may_shrink && room() >= min_cells);
        if (!fits && !all.empty()) {
            at = indent + 4;
            ++line;
        }
        if (width != 0 && may_shrink) cells = std::min(cells, std::max<std::size_t>(room(), 1));
        all.push_back({i, line, at, cells, is_right});
        at += cells + 2;
    }
    return all;
}

void Table::write(std::ostream& out, std::string_view indent, std::size_t width) const {
    const std::vector<Column> places = columns(indent.size(), width);
    const auto end = [&](std::string& text) {
        out << text.substr(0, text.find_last_not_of(' ') + 1) << '\n';
        text.clear();
    };
    const auto write_line = [&](const Line& line) {
        std::string text;
        if (line.size() != heading_.size())
            return end(text = wrapped(std::string{indent} + line.front(), width, indent.size() + 4));
        std::size_t cells = 0, in_line = 0;
        for (const Column& column : places) {
            if (column.line != in_line) {
                end(text);
                cells = 0;
                in_line = column.line;
            }
            text.append(column.at - cells, ' ');
            const std::string& cell = line[column.number];
            const std::size_t space = column.width - std::min(column.width, cells_of(cell));
            if (column.is_right) text.append(space, ' ');
            if (width != 0 && column.number + 1 == line.size())
                text += wrapped(cell, column.at + column.width, column.at, column.at);
            else text += cell;
            if (!column.is_right) text.append(space, ' ');
            cells = column.at + column.width;
        }
        end(text);
    };
    Line heading = heading_;
    for (std::string& name : heading) name.erase(0, name.find_first_not_of(' '));
    write_line(heading);
    for (const Line& line : lines_) write_line(line);
}

}    // namespace anoctl
