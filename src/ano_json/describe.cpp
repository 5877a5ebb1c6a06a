#include "reference.hpp"

#include <ano/messages.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <string>

namespace anoctl {
namespace {

using namespace ano;

Json field_json(const Field& f) {
    Json json{{"name", f.name}, {"type", name_of(f.type)}};
    if (f.is_open()) json["count"] = nullptr;
    else if (f.count != 1) json["count"] = f.count;
    json["offset"] = f.offset;
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
    json["acknowledged"] = acknowledged[static_cast<std::size_t>(row.acknowledged)];
    json["fields"] = Json::array();
    for (const Field& f : row.fields()) json["fields"].push_back(field_json(f));
    for (const Field& f : row.element()) json["element"].push_back(field_json(f));
    return json;
}

}    // namespace anoctl
