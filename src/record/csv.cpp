#include <record/csv.hpp>

#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano/reading.hpp>
#include <ano_json/json_writer.hpp>
#include <ano_json/restored.hpp>
#include <ano_json/shown_text.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace anogate {
namespace {

void append_number(auto number, std::string& out) {
    std::array<char, 32> room;
    out.append(room.data(), std::to_chars(room.data(), room.data() + room.size(), number).ptr);
}

// Quoted if necessary.
void append_cell(std::string_view text, std::string& out) {
    if (text.find_first_of(",\"\r\n") == text.npos) {
        out += text;
        return;
    }
    out += '"';
    for (const char c : text) out.append(c == '"' ? 2 : 1, c);
    out += '"';
}

// Appends nothing for a value that JSON can't represent, such as NaN.
void append_value(const ano::Field& f, const ano::Value& value, std::string& out) {
    if (const auto* const real = std::get_if<double>(&value)) {
        if (!std::isfinite(*real)) return;
        const bool is_float = f.type == ano::Type::f32 && f.scale.is_one();
        append_number(is_float ? ano::widened(static_cast<float>(*real)) : *real, out);
    } else if (const auto* const whole = std::get_if<std::int64_t>(&value)) {
        append_number(*whole, out);
    } else if (const auto* const natural = std::get_if<std::uint64_t>(&value)) {
        append_number(*natural, out);
    }
}

bool is_array(const ano::Field& f) noexcept { return is_number(f.type) && f.count > 1; }

}    // namespace

CsvWriter::CsvWriter(std::uint8_t id, const ano::JsonOptions& options) : id_{id}, options_{options} {
    for (const ano::Message& row : ano::layouts_of(id)) add_columns(row.fields());
    if (options.flexible == nullptr) return;
    for (const ano::FlexibleLayout& layout : options.flexible->all())
        if (layout.id() == id) add_columns(layout.fields());
}

// Forgets the cells, which are keyed by address: a new layout may have the address of an old one.
void CsvWriter::use(const ano::FlexibleLayouts& flexible) {
    options_.flexible = &flexible;
    cells_.clear();
}

bool CsvWriter::has_columns_for(const ano::FlexibleLayouts& flexible) const {
    const CsvWriter other{id_, {&flexible}};
    return std::all_of(other.columns_.begin(), other.columns_.end(), [this](const Column& column) {
        return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
    });
}

// Fields with the same name and unit share a column across layouts.
void CsvWriter::add_columns(std::span<const ano::Field> fields) {
    for (const ano::Field& f : fields) {
        for (int i = is_array(f) ? 0 : -1; i < (is_array(f) ? int{f.count} : 0); ++i) {
            const bool known = std::any_of(columns_.begin(), columns_.end(),
                                           [&](const Column& c) { return c.is_of(f) && c.element == i; });
            if (!known) columns_.push_back({f.name, i, f.unit});
        }
    }
}

const CsvWriter::Cells& CsvWriter::cells_of(std::span<const ano::Field> layout) {
    const auto [at, is_new] = cells_.try_emplace(layout.data());
    Cells& cells = at->second;
    if (!is_new) return cells;
    cells.fields.resize(columns_.size());
    for (const ano::Field& f : layout) {
        bool has_last = false;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const int element = columns_[i].element;
            if (!columns_[i].is_of(f) || (element >= 0 && (!is_array(f) || element >= f.count))) continue;
            cells.fields[i] = &f;
            has_last = has_last || element == (is_array(f) ? f.count - 1 : -1);
        }
        cells.are_all = cells.are_all && has_last;
    }
    return cells;
}

void CsvWriter::write_heading(std::string& out) const {
    out += "time [s],link,peer,frame_direction,frame_cause,from,to";
    for (const Column& column : columns_) {
        std::string text{column.field};
        if (column.element >= 0) text += '.' + std::to_string(column.element);
        if (!column.unit.empty()) text.append(" [").append(column.unit) += ']';
        out += ',';
        append_cell(text, out);
    }
    out += ",frame_extra,frame_data\n";
}

void CsvWriter::write(const RecordedFrame& frame, std::string& out) {
    append_seconds(frame.time_ns, out);
    for (const std::string_view text : {frame.link, frame.peer, text(frame.direction), frame.cause}) {
        out += ',';
        append_cell(text, out);
    }
    for (const std::uint8_t address : {frame.frame.source(), frame.frame.destination()}) {
        out += ',';
        append_number(unsigned{address}, out);
    }
    const ano::Reading reading = ano::read(frame.frame, options_.flexible);
    if (!reading) {
        out.append(columns_.size() + 2, ',');
        out += ano::hex(frame.frame.data());
    } else {
        const Cells& cells = cells_of(reading.fields());
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            out += ',';
            if (cells.fields[i] != nullptr) write_cell(reading, *cells.fields[i], columns_[i].element, out);
        }
        out += ',';
        if (!reading.extra().empty()) out += ano::hex(reading.extra());
        out += ',';
        if (!cells.are_all || !ano::is_restored(frame.frame, reading, options_)) out += ano::hex(frame.frame.data());
        else if (reading.fields().back().type == ano::Type::frames) out += ano::hex_between_frames(reading);
    }
    out += '\n';
}

void CsvWriter::write_cell(const ano::Reading& reading, const ano::Field& f, int element, std::string& out) {
    if (is_number(f.type) && element < 0 && !is_array(f)) return append_value(f, reading.value(f), out);
    if (element >= 0) {
        const std::size_t at = static_cast<std::size_t>(element) * width(f.type);
        return append_value(f, value_at(f, reading.bytes_of(f).data() + at), out);
    }
    if (f.type == ano::Type::bytes) {
        out += ano::hex(reading.bytes_of(f));
        return;
    }
    if (f.type == ano::Type::ip) {
        out += ano::address_text(reading.bytes_of(f));
        return;
    }
    if (f.type == ano::Type::text) {
        const auto text = std::get<std::string_view>(reading.value(f));
        return ano::is_ascii(text) ? append_cell(text, out) : append_cell(ano::display_text(text, options_.encoding), out);
    }
    json_.clear();
    ano::JsonWriter json{json_};
    ano::write_value(reading, f, options_, json);
    if (json_ != "[]") append_cell(json_, out);
}

std::string recorded_json(const Recorded& item, const ano::JsonOptions& options) {
    std::string text;
    ano::JsonWriter out{text};
    out.begin_object();
    if (const auto* loss = std::get_if<RecordedLoss>(&item)) {
        out.key("lost");
        out.number(loss->count);
        out.text("messages", loss->names);
    } else {
        const auto& frame = std::get<RecordedFrame>(item);
        ano::write_frame(frame.frame, options, out);
        out.key("time");
        out.number(json_seconds(frame.time_ns));
        out.text("link", frame.link);
        if (!frame.peer.empty()) out.text("peer", frame.peer);
        out.text("direction", anogate::text(frame.direction));
        if (!frame.cause.empty()) out.text("cause", frame.cause);
    }
    out.end_object();
    return text;
}

}    // namespace anogate
