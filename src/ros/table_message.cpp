#include <ano/messages.hpp>
#include <ano_json/shown_text.hpp>
#include <ros/field_comment.hpp>
#include <ros/ros_names.hpp>
#include <ros/table_message.hpp>

#include <algorithm>
#include <array>
#include <set>

namespace anogate {
namespace {

using ano::Field;
using Shape = RosField::Shape;

RosType type_on_the_wire(ano::Type type) noexcept {
    static constexpr std::array types{RosType::uint8, RosType::int8,   RosType::uint16, RosType::int16,   RosType::uint32,
                                      RosType::int32, RosType::uint64, RosType::int64,  RosType::float32, RosType::float64};
    return types[static_cast<std::size_t>(type)];
}

RosType type_of(const Field& f) noexcept {
    using enum ano::Type;
    if (f.type == list) return RosType::message;
    if (f.type == text || f.type == ip) return RosType::text;
    if (!is_number(f.type)) return RosType::uint8;
    return f.scale.is_one() ? type_on_the_wire(f.type) : RosType::float64;
}

bool is_float(RosType type) noexcept { return type == RosType::float32 || type == RosType::float64; }

Shape shape_of(const Field& f) noexcept {
    using enum ano::Type;
    if (f.type == list) return Shape::sequence;
    if (f.type == text || f.type == ip) return Shape::one;
    if (is_number(f.type) && f.count == 1) return Shape::one;
    return f.is_open() ? Shape::sequence : Shape::array;
}

// Constants for the meanings of a whole number. Programs show their names before the field.
std::vector<RosConstant> constants_of(const Field& f, const std::string& name) {
    std::vector<RosConstant> constants;
    std::set<std::string> taken;
    for (const ano::Meaning& m : f.meanings)
        constants.push_back({unique_name(upper_case_name(name + ' ' + std::string{m.text}, "VALUE"), taken), m.value});
    return constants;
}

void append_text(std::string_view text, ValueList& out) {
    if (ano::is_utf8(text)) return out.push(ano::Value{text});
    out.push_copy(ano::display_text(text, ano::Encoding::automatic));
}

void append_absent(const RosField& as, ValueList& out) {
    if (as.shape == Shape::sequence && as.type != RosType::uint8) out.push_count(0);
    else out.push(ano::Value{ano::Nothing{}});
}

}    // namespace

const Field& TableMessage::Column::sample() const noexcept {
    return **std::find_if(fields.begin(), fields.end(), [](const Field* f) { return f != nullptr; });
}

bool TableMessage::Column::is_everywhere() const noexcept {
    return std::find(fields.begin(), fields.end(), nullptr) == fields.end();
}

TableMessage::TableMessage(std::uint8_t id) {
    for (const ano::Message& row : ano::layouts_of(id)) layouts_.push_back({&row, row.fields()});
    const ano::Message& base = *layouts_.front().row;
    build(camel_case(base.name));
    type_.comment = base.title;
}

TableMessage::TableMessage(const ano::FlexibleLayout& layout) {
    layouts_.push_back({nullptr, layout.fields()});
    const ano::Message& base = *ano::find_message(layout.id());
    build(camel_case(base.name) + (layout.source() ? "From" + std::to_string(*layout.source()) : "") +
          (layout.when() ? "When" + std::to_string(*layout.when()) : ""));
    type_.comment = base.title;
}

void TableMessage::build(const std::string& name) {
    type_.package = "ano_msgs";
    type_.name = name;
    for (std::size_t i = 0; i < layouts_.size(); ++i)
        for (const Field& field : layouts_[i].fields) add_column(i, field);
    std::set<std::string> taken;
    for (const Column& column : columns_) {
        const Field& f = column.sample();
        std::string field_name = lower_case_name(f.name, "value");
        if (taken.contains(field_name) && column.fields.front() == nullptr) {
            const auto layout = std::find(column.fields.begin(), column.fields.end(), &f) - column.fields.begin();
            field_name += '_' + std::string{layouts_[static_cast<std::size_t>(layout)].row->variant.label};
        }
        type_.fields.push_back(field_of(column, unique_name(field_name, taken)));
    }
}

// Fields with the same name and unit share a column across layouts.
void TableMessage::add_column(std::size_t layout, const Field& field) {
    for (Column& column : columns_) {
        const Field& f = column.sample();
        const bool same = f.name == field.name && f.unit == field.unit && shape_of(f) == shape_of(field) &&
                          is_number(f.type) == is_number(field.type) && f.count == field.count;
        if (!same || column.fields[layout] != nullptr) continue;
        column.fields[layout] = &field;
        return;
    }
    Column column{std::vector<const Field*>(layouts_.size())};
    column.fields[layout] = &field;
    columns_.push_back(std::move(column));
}

RosField TableMessage::field_of(const Column& column, const std::string& name) {
    const Field& f = column.sample();
    const bool everywhere = column.is_everywhere();
    RosField field{.type = type_of(f), .name = name, .shape = shape_of(f), .count = f.count};
    bool has_no_data = false;
    for (const Field* other : column.fields) {
        if (other == nullptr) continue;
        has_no_data = has_no_data || other->no_data;
        if (type_of(*other) != field.type) field.type = RosType::float64;
    }
    if (!everywhere && field.shape == Shape::array) field.shape = Shape::sequence;
    const bool is_scalar = field.shape == Shape::one && is_number(f.type);
    if (is_scalar && (!everywhere || has_no_data) && !is_float(field.type)) field.type = RosType::float64;
    if (field.type == RosType::message) field.message = element_of(column);
    const bool is_whole = is_number(f.type) && !is_float(field.type);
    if (is_whole) field.constants = constants_of(f, name);
    field.comment = comment_of(f, !is_whole);
    const auto add = [&](std::string_view text) { field.comment += (field.comment.empty() ? "" : "; ") + std::string{text}; };
    if (lower_case_name(f.name, "") != f.name) add(f.name);
    if (has_no_data) add("NaN: no data");
    if (!everywhere) add(is_scalar ? "NaN where the frame does not have it" : "empty where the frame does not have it");
    return field;
}

const RosMessage* TableMessage::element_of(const Column& column) {
    const auto at = std::find(column.fields.begin(), column.fields.end(), &column.sample()) - column.fields.begin();
    const ano::Message& row = *layouts_[static_cast<std::size_t>(at)].row;
    std::string name = camel_case(row.name) + camel_case(column.sample().name);
    if (name.back() == 's') name.pop_back();
    element_ = std::make_unique<RosMessage>(RosMessage{.package = "ano_msgs", .name = std::move(name)});
    for (const Field& f : row.element())
        element_->fields.push_back(
            {.type = f.no_data ? RosType::float64 : type_of(f), .name = std::string{f.name}, .comment = comment_of(f, true)});
    return element_.get();
}

void TableMessage::append_values(const ano::Reading& reading, ValueList& out) const {
    std::size_t layout = 0;
    while (layout + 1 < layouts_.size() && layouts_[layout].row != reading.message()) ++layout;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        const Field* field = columns_[i].fields[layout];
        if (field == nullptr) append_absent(type_.fields[i], out);
        else append_value(*field, type_.fields[i], reading, out);
    }
}

void TableMessage::append_value(const Field& field, const RosField& as, const ano::Reading& reading, ValueList& out) const {
    if (is_number(field.type) && field.count == 1) return out.push(reading.value(field));
    const ano::Bytes bytes = reading.bytes_of(field);
    if (field.type == ano::Type::text) return append_text(std::get<std::string_view>(reading.value(field)), out);
    if (field.type == ano::Type::ip) return out.push_copy(ano::address_text(bytes));
    if (field.type == ano::Type::list) {
        out.push_count(reading.element_count());
        for (std::size_t i = 0; i < reading.element_count(); ++i)
            for (const Field& f : reading.element_fields()) out.push(reading.element(i, f));
        return;
    }
    if (as.type == RosType::uint8) return out.push(ano::Value{bytes});
    if (as.shape == Shape::sequence) out.push_count(field.count);
    for (std::size_t at = 0; at < bytes.size(); at += width(field.type)) out.push(value_at(field, bytes.data() + at));
}

}    // namespace anogate
