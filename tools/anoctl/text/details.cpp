#include "reference.hpp"
#include "table.hpp"

#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/text.hpp>
#include <ano_json/words.hpp>

#include <ostream>
#include <string>
#include <string_view>

namespace anoctl {
namespace {

using namespace ano;

// The values that select the layout; else the documented range; else the range of the type.
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

using Line = Table::Line;

Line line_of(const Field& f, const std::string& indent) {
    return {indent + std::string{f.name}, type_text(f), std::string{f.unit}, range_text(f), values_text(f)};
}

}    // namespace

void write_details(std::ostream& out, const Message& row, bool color) {
    const auto dimmed = [&](const std::string& text) { return color ? "\x1b[2m" + text + "\x1b[0m" : text; };
    out << hex_byte(row.id) << ' ' << row.name << ' ' << dimmed(std::string{name_of(row.traffic.traffic_class)}) << ": "
        << row.title;
    if (!row.is_base()) out << " (layout " << row.variant.label << selection_rule(row) << ')';
    if (row.is_base()) out << selection_rule(row);
    out << '\n';
    Table table{{"field", "type", "unit", "range", "values"}};
    for (const Field& f : row.fields()) table.row(line_of(f, ""));
    for (const Field& f : row.element()) table.row(line_of(f, "  "));
    if (table.empty()) out << "    as configured\n";
    else table.write(out, "    ");
}

}    // namespace anoctl
