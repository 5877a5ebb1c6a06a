#include <ano/messages.hpp>
#include <ano_json/compact_json.hpp>
#include <ano_json/json_writer.hpp>
#include <ros/field_comment.hpp>
#include <ros/json_message.hpp>

#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using ano::Json;

Json object_schema() { return {{"type", "object"}, {"properties", Json::object()}}; }

Json number_schema(const ano::Field& f) { return {{"type", is_integer(f.type) && f.scale.is_one() ? "integer" : "number"}}; }

Json schema_of(const ano::Field& f, std::span<const ano::Field> element) {
    using enum ano::Type;
    if (f.type == list) {
        Json items = object_schema();
        for (const ano::Field& e : element) items["properties"][std::string{e.name}] = schema_of(e, {});
        return {{"type", "array"}, {"items", std::move(items)}};
    }
    if (f.type == frames) return {{"type", "array"}, {"items", object_schema()}};
    if (!is_number(f.type)) return {{"type", "string"}};
    if (f.count == 1) return number_schema(f);
    return {{"type", "array"}, {"items", number_schema(f)}};
}

void add_field(const ano::Field& f, std::span<const ano::Field> element, Json& properties) {
    Json schema = schema_of(f, element);
    std::string comment = comment_of(f, true);
    if (f.type == ano::Type::bytes) comment += comment.empty() ? "hex" : "; hex";
    Json& known = properties[std::string{f.name}];
    if (known.is_null()) {
        if (!comment.empty()) schema["description"] = comment;
        known = std::move(schema);
    } else {    // another layout has the field as well
        if (known["type"] != schema["type"]) known["type"] = "number";
        const std::string before = known.value("description", "");
        if (!comment.empty() && before.find(comment) == before.npos)
            known["description"] = before.empty() ? comment : before + "; or " + comment;
    }
    if (f.type == ano::Type::frames) properties["data"] = {{"type", "string"}, {"description", "hex; what is no whole frame"}};
}

Json schema_called(std::string_view name, std::string_view title) {
    Json schema{{"title", name}, {"description", title}};
    schema.update(object_schema());
    return schema;
}

}    // namespace

std::string json_schema_of(std::span<const ano::Message> layouts) {
    Json schema = schema_called(layouts.front().name, layouts.front().title);
    for (const ano::Message& row : layouts)
        for (const ano::Field& f : row.fields()) add_field(f, row.element(), schema["properties"]);
    return ano::compact_json(schema);
}

std::string json_schema_of(const ano::FlexibleLayout& layout) {
    const ano::Message& base = *ano::find_message(layout.id());
    Json schema = schema_called(base.name, base.title);
    for (const ano::Field& f : layout.fields()) add_field(f, {}, schema["properties"]);
    return ano::compact_json(schema);
}

void write_json_message(const ano::Reading& reading, const ano::JsonOptions& options, std::string& out) {
    ano::JsonWriter json{out};
    json.begin_object();
    ano::write_fields(reading, options, json, true);
    json.end_object();
}

}    // namespace anogate
