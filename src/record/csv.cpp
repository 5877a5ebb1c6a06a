#include <record/csv.hpp>

#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano/reading.hpp>
#include <ano_json/compact_json.hpp>
#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>

namespace anogate {
namespace {

using ano::Json;

// Quoted if necessary.
std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == text.npos) return text;
    std::string cell = "\"";
    for (const char c : text) cell.append(c == '"' ? 2 : 1, c);
    return cell + '"';
}

std::string csv_cell(const Json& value) {
    if (value.is_null() || (value.is_array() && value.empty())) return {};
    if (value.is_string()) return csv_cell(value.get_ref<const std::string&>());
    if (value.is_number_float()) return ano::number_text(value.get<double>());
    return csv_cell(value.dump());
}

const Json& member(const Json& object, const std::string& key) {
    static const Json nothing;
    const auto found = object.find(key);
    return found != object.end() ? *found : nothing;
}

}    // namespace

CsvWriter::CsvWriter(std::uint8_t id, const ano::JsonOptions& options) : options_{options} {
    for (const ano::Message& row : ano::layouts_of(id)) add_columns(row.fields());
    if (options.flexible == nullptr) return;
    for (const ano::FlexibleLayout& layout : options.flexible->all())
        if (layout.id() == id) add_columns(layout.fields());
}

// Layouts share the columns of fields with the same name and unit.
void CsvWriter::add_columns(std::span<const ano::Field> fields) {
    for (const ano::Field& f : fields) {
        const std::string name{f.name};
        const bool is_array = is_number(f.type) && f.count > 1;
        for (int i = is_array ? 0 : -1; i < (is_array ? int{f.count} : 0); ++i) {
            const bool known = std::any_of(columns_.begin(), columns_.end(), [&](const Column& c) {
                return c.field == name && c.element == i && c.unit == f.unit;
            });
            if (!known) columns_.push_back({name, i, std::string{f.unit}});
        }
    }
}

bool CsvWriter::has_column(std::string_view field) const {
    return std::any_of(columns_.begin(), columns_.end(), [&](const Column& c) { return c.field == field; });
}

bool CsvWriter::has_column(const ano::Field& f) const {
    const int last = is_number(f.type) && f.count > 1 ? f.count - 1 : -1;
    return std::any_of(columns_.begin(), columns_.end(),
                       [&](const Column& c) { return c.field == f.name && c.element == last && c.unit == f.unit; });
}

void CsvWriter::write_heading(std::string& out) const {
    out += "time [s],link,peer,frame_direction,frame_cause,from,to";
    for (const Column& column : columns_) {
        std::string text = column.field;
        if (column.element >= 0) text += '.' + std::to_string(column.element);
        if (!column.unit.empty()) text += " [" + column.unit + ']';
        out += ',' + csv_cell(text);
    }
    out += ",frame_extra,frame_data\n";
}

void CsvWriter::write(const RecordedFrame& frame, std::string& out) const {
    const Json json = ano::frame_to_json(frame.frame, options_);
    out += seconds_text(frame.time_ns);
    for (const std::string_view text : {frame.link, frame.peer, text(frame.direction), frame.cause})
        out += ',' + csv_cell(std::string{text});
    for (const std::uint8_t address : {frame.frame.source(), frame.frame.destination()}) out += ',' + std::to_string(address);
    const Json& fields = member(json, "fields");
    const ano::Reading reading = ano::read(frame.frame, options_.flexible);
    for (const Column& column : columns_) {
        out += ',';
        const ano::Field* field = reading.field(column.field);
        if (field == nullptr || field->unit != column.unit || !fields.is_object()) continue;
        const Json& value = member(fields, column.field);
        const auto element = static_cast<std::size_t>(std::max(column.element, 0));
        if (column.element < 0) out += csv_cell(value);
        else if (value.is_array() && element < value.size()) out += csv_cell(value[element]);
    }
    out += ',' + csv_cell(member(json, "extra")) + ',';
    Json whole;
    for (const ano::Field& f : reading.fields())
        if (!has_column(f)) whole = ano::hex(frame.frame.data());
    const Json& data = whole.is_null() ? member(json, "data") : whole;
    const bool has_rest = data.is_null() && fields.is_object() && !has_column("data");    // of a tunnel: not a whole frame
    out += csv_cell(has_rest ? member(fields, "data") : data);
    out += '\n';
}

std::string recorded_json(const Recorded& item, const ano::JsonOptions& options) {
    Json json;
    if (const auto* loss = std::get_if<RecordedLoss>(&item)) {
        json["lost"] = loss->count;
        json["messages"] = loss->names;
    } else {
        const auto& frame = std::get<RecordedFrame>(item);
        json = ano::frame_to_json(frame.frame, options);
        json["time"] = json_seconds(frame.time_ns);
        json["link"] = frame.link;
        if (!frame.peer.empty()) json["peer"] = frame.peer;
        json["direction"] = text(frame.direction);
        if (!frame.cause.empty()) json["cause"] = frame.cause;
    }
    return ano::compact_json(json);
}

}    // namespace anogate
