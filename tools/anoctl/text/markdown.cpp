#include "reference.hpp"

#include <ano/conversation.hpp>
#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/text.hpp>

#include <array>
#include <ostream>
#include <string>

namespace anoctl {
namespace {

using namespace ano;

constexpr const char* introduction = R"(# Messages of the ANO V8 protocol

Made by `tools/update-generated` (`anoctl messages --markdown`) from the table in `include/ano/messages.hpp`.

Numbers are little-endian where nothing else is said, and packed. *Value* = what is on the wire × *scale*, in *unit*. A layout with a length of its own
is taken at exactly that length of DATA, one with a mode where the named field holds one of the named values, one that says
where it is taken there; everything else is the base layout. What stands behind a layout is kept as `extra`; fewer bytes are
malformed. A base layout with an exact length has nothing behind it: a length that no layout has is an unknown layout.
So it is in each message that replaces its predecessor ("replaced") and does not end in a field of open length: some devices put others
before the fields.
Classes say what leaves first where a line is slow. *Replaced*: a newer frame of the same source, destination and id (and
first byte of DATA, where it says so) may take the place of one that waits on a congested line.
)";

std::string scale_text(const Field& f) {
    if (f.scale.is_one()) return {};
    const double factor = f.scale.factor();
    const bool decimal = number_text(factor).size() <= 6;
    return decimal ? number_text(factor) : number_text(f.scale.value) + "/" + number_text(f.scale.wire);
}

std::string remark(const Field& f) {
    std::string text;
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
    if (!f.label.empty()) add(std::string{f.label});
    if (f.selects) {
        std::string only = "here " + std::to_string(f.selects->first);
        if (f.selects->last != f.selects->first) only += " to " + std::to_string(f.selects->last);
        add(only);
    }
    if (f.range) add(number_text(f.range.first) + " to " + number_text(f.range.last));
    if (f.no_data) add(std::to_string(*f.no_data) + " on the wire: no data");
    for (const Meaning& m : f.meanings) add(std::to_string(m.value) + " " + std::string{m.text});
    if (!f.note.empty()) add(std::string{f.note});
    return text;
}

void write_rows_of_fields(std::ostream& out, std::span<const Field> fields, const std::string& base) {
    for (const Field& f : fields)
        out << "| " << base << f.offset << " | `" << f.name << "` | " << type_text(f) << " | " << scale_text(f) << " | " << f.unit
            << " | " << remark(f) << " |\n";
}

void write_layout(std::ostream& out, const Message& row) {
    out << '\n' << row.title << '.';
    if (!row.is_base()) out << " Layout `" << row.variant.label << "`";
    if (row.is_base() && row.variant.length != 0) out << " The base layout";
    out << selection_rule(row);
    if (!row.is_base() || row.variant.length != 0) out << '.';
    if (acknowledged(row) == Acknowledged::yes) out << " Acknowledged.";
    if (acknowledged(row) == Acknowledged::as_write)
        out << " Acknowledged if it is a write, not if it is the response to a read.";
    if (row.fields().empty()) {
        out << " The layout comes from the configuration.\n";
        return;
    }
    out << "\n\n| at | field | type | scale | unit | |\n|---:|---|---|---:|---|---|\n";
    write_rows_of_fields(out, row.fields(), "");
    write_rows_of_fields(out, row.element(), "+");
}

}    // namespace

std::string type_text(const Field& f) {
    std::string text{name_of(f.type)};
    if (f.is_open()) return text + ", to the end";
    if (f.count != 1) text += "[" + std::to_string(f.count) + "]";
    if (f.order == ByteOrder::big) text += ", high byte first";
    return text;
}

std::string selection_rule(const Message& row) {
    if (row.variant.by_look)
        return ", used if the base layout would give a value out of range or unreadable text, and this layout does not";
    return row.variant.length == 0 ? "" : ", at exactly " + std::to_string(row.variant.length) + " bytes";
}

void write_markdown(std::ostream& out) {
    static constexpr std::array replaced{"", ", replaced", ", replaced by first byte"};
    out << introduction;
    for (const Message& row : messages) {
        if (row.is_base())
            out << "\n## " << hex_byte(row.id) << " " << row.name << "\n\n*" << name_of(row.traffic.traffic_class)
                << replaced[static_cast<std::size_t>(row.traffic.replaces)] << "*\n";
        write_layout(out, row);
    }
}

}    // namespace anoctl
