#include <ano/conversation.hpp>
#include <ano/messages.hpp>
#include <ano_json/describe.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <span>
#include <string>

namespace ano {
namespace {

Json field_json(const Field& f) {
    Json json{{"name", f.name}, {"type", name_of(f.type)}};
    if (f.is_open()) json["count"] = nullptr;
    else if (f.count != 1) json["count"] = f.count;
    json["offset"] = f.offset;
    if (f.order == ByteOrder::big) json["endian"] = "big";
    if (is_number(f.type)) json["scale"] = f.scale.factor();
    if (!f.unit.empty()) json["unit"] = f.unit;
    if (f.range) json["range"] = {f.range.first, f.range.last};
    if (f.no_data) json["no_data"] = *f.no_data;
    if (f.selects) json["only"] = {f.selects->first, f.selects->last};
    if (!f.label.empty()) json["label"] = f.label;
    if (!f.note.empty()) json["note"] = f.note;
    if (!f.meanings.empty()) json["values"] = Json::object();
    for (const Meaning& m : f.meanings) json["values"][std::to_string(m.value)] = m.text;
    return json;
}

Json fields_json(std::span<const Field> fields) {
    Json json = Json::array();
    for (const Field& f : fields) json.push_back(field_json(f));
    return json;
}

}    // namespace

Json describe(const Message& row) {
    static constexpr std::array replaces{"nothing", "same_id", "same_first_byte"};
    static constexpr std::array acknowledged{"no", "yes", "as_write"};
    Json json{{"id", row.id}, {"name", row.name}, {"title", row.title}};
    if (!row.is_base()) json["layout"] = row.variant.label;
    if (row.variant.length != 0) json["length"] = row.variant.length;
    if (row.variant.by_look) json["by_look"] = true;
    json["size"] = row.fixed_size;
    json["class"] = name_of(row.traffic.traffic_class);
    json["replaces"] = replaces[static_cast<std::size_t>(row.traffic.replaces)];
    json["acknowledged"] = acknowledged[static_cast<std::size_t>(ano::acknowledged(row))];
    json["fields"] = fields_json(row.fields());
    for (const Field& f : row.element()) json["element"].push_back(field_json(f));
    return json;
}

std::vector<Json> describe_all(const FlexibleLayouts& flexible) {
    std::vector<Json> rows;
    for (const Message& row : messages) {
        bool is_for_all = false;    // a configured layout replaces the row of the table
        for (const FlexibleLayout& layout : flexible.all()) {
            if (layout.id() != row.id) continue;
            Json& json = rows.emplace_back(describe(row));
            json["size"] = layout.size();
            json["fields"] = fields_json(layout.fields());
            if (layout.source()) json["source"] = *layout.source();
            else is_for_all = is_for_all || !layout.when();
        }
        if (!is_for_all) rows.push_back(describe(row));
    }
    return rows;
}

}    // namespace ano
