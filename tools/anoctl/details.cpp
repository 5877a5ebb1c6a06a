#include "reference.hpp"

#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/text.hpp>
#include <ano_json/words.hpp>

#include <algorithm>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {
namespace {

using namespace ano;

// The values that select the layout, otherwise the documented range, otherwise the range of the type.
std::string range_text(const Field& f) {
    if (f.selects && f.selects->first == f.selects->last) return std::to_string(f.selects->first);
    if (f.selects) return std::to_string(f.selects->first) + " to " + std::to_string(f.selects->last);
    if (f.range) return number_text(f.range.first) + " to " + number_text(f.range.last);
    if (!is_integer(f.type)) return {};
    const std::string text = carried(f);    // "i16, -327.68 to 327.67 °"
    const std::string range = text.substr(text.find(", ") + 2);
    return f.unit.empty() ? range : range.substr(0, range.size() - f.unit.size() - 1);
}

std::string values_text(const Field& f) {
    std::string text;
    const auto add = [&](std::string_view part) { text.append(text.empty() ? "" : "; ").append(part); };
    add(f.label);
    std::string meanings;
    for (const Meaning& m : f.meanings) {
        if (f.selects && (m.value < f.selects->first || m.value > f.selects->last)) continue;
        meanings.append(meanings.empty() ? "" : ", ").append(std::to_string(m.value)).append(" ").append(m.text);
    }
    if (!meanings.empty()) add(meanings);
    if (f.no_data) add("null: no data");
    if (f.role == Role::value) add("written as f32:1.5, string:abc or hex digits");
    if (f.role == Role::values) add("written as u16:100,i32:-5 or hex digits");
    if (!f.note.empty()) add(f.note);
    return text;
}

std::size_t characters(std::string_view text) {
    return static_cast<std::size_t>(
        std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

using Line = std::vector<std::string>;

Line line_of(const Field& f, const std::string& indent) {
    return {indent + std::string{f.name}, type_text(f), std::string{f.unit}, range_text(f), values_text(f)};
}

// The first line is the heading; a column without anything below it is left out.
void write_columns(std::ostream& out, std::span<const Line> lines) {
    std::vector<std::size_t> widths(lines.front().size());
    for (const Line& line : lines.subspan(1))
        for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], characters(line[i]));
    for (std::size_t i = 0; i < widths.size(); ++i)
        if (widths[i] > 0) widths[i] = std::max(widths[i], characters(lines.front()[i]));
    for (const Line& line : lines) {
        std::string text = "    ";
        for (std::size_t i = 0; i < line.size(); ++i)
            if (widths[i] > 0) text += line[i] + std::string(widths[i] - characters(line[i]) + 2, ' ');
        out << text.substr(0, text.find_last_not_of(' ') + 1) << '\n';
    }
}

}    // namespace

void write_details(std::ostream& out, const Message& row, bool color) {
    const auto dimmed = [&](const std::string& text) { return color ? "\x1b[2m" + text + "\x1b[0m" : text; };
    out << hex_byte(row.id) << ' ' << row.name << ' ' << dimmed(std::string{name_of(row.traffic.traffic_class)}) << ": "
        << row.title;
    if (!row.is_base()) out << " (layout " << row.variant.label << taken_for(row) << ')';
    out << '\n';
    std::vector<Line> lines{{"field", "type", "unit", "range", "values"}};
    for (const Field& f : row.fields()) lines.push_back(line_of(f, ""));
    for (const Field& f : row.element()) lines.push_back(line_of(f, "  "));
    if (lines.size() == 1) out << "    as configured\n";
    else write_columns(out, lines);
}

}    // namespace anoctl
