#include <config/config.hpp>
#include <config/keys.hpp>
#include <link/kinds.hpp>

#include <charconv>
#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

Json choices_of(const KeyFacts& key) {
    Json list = Json::array();
    for (const std::string_view choice : split(key.choices, '|')) list.push_back(choice);
    return list;
}

/// The JSON that a value may be.
Json type_of(const KeyFacts& key) {
    const Json number{{"type", "integer"}, {"minimum", key.least}, {"maximum", key.most}};
    const auto text = [](const char* pattern) { return Json{{"type", "string"}, {"pattern", pattern}}; };
    switch (key.form) {
    case Form::boolean: return {{"type", "boolean"}};
    case Form::integer: return number;
    case Form::address:
    case Form::can_id: return {{"anyOf", {number, text("^(0[xX][0-9A-Fa-f]+|[0-9]+)$")}}};
    case Form::addresses: return {{"anyOf", {number, text("^(0[xX][0-9A-Fa-f]+|[0-9]+)(-(0[xX][0-9A-Fa-f]+|[0-9]+))?$")}}};
    case Form::duration: return text("^[0-9]+(ms|s|m|h)$");
    case Form::interval: return {{"anyOf", {Json{{"type", "boolean"}}, text("^(on|off|[0-9]+(ms|s|m|h))$")}}};
    case Form::size: return {{"anyOf", {number, text("^[0-9]+([kKMG]B|[KMG]iB)?$")}}};
    case Form::choice: return {{"enum", choices_of(key)}};
    case Form::choice_or_link:
        return {{"anyOf", {Json{{"enum", choices_of(key)}}, Json{{"type", "string"}, {"minLength", key.least}}}}};
    case Form::text: return {{"type", "string"}, {"minLength", key.least}, {"maxLength", key.most}};
    case Form::endpoint: return text("^.+:[0-9]+$");
    case Form::network:
    case Form::ip: return {{"type", "string"}};
    case Form::line:
        return {{"anyOf",
                 {Json{{"type", "integer"}, {"minimum", 0}},
                  Json{{"type", "string"}, {"minLength", key.least}, {"maxLength", key.most}}}}};
    case Form::silence: return text("^silent [0-9]+(ms|s|m|h)$");
    case Form::frames:
    case Form::senders: return {{"type", "array"}, {"items", {{"type", Json::array({"string", "integer"})}}}, {"minItems", 1}};
    case Form::limits: return {{"type", "object"}, {"additionalProperties", {{"type", "number"}, {"exclusiveMinimum", 0}}}};
    case Form::names: return {{"type", "array"}, {"items", {{"type", "string"}}}};
    case Form::networks:
        return {{"anyOf", {Json{{"const", "any"}}, Json{{"type", "array"}, {"items", {{"type", "string"}}}, {"minItems", 1}}}}};
    }
    return {};
}

Json closed_object() { return {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}}; }

template <class Section>
Json& add_keys(Json& object, Keys<Section> keys, std::string_view kind = {}) {
    for (const Key<Section>& key : keys) {
        if (!key.is_of(kind)) continue;
        Json property{{"description", key.help}};
        property.update(type_of(key));
        Json* in = &object;
        const auto names = split(key.name, '.');
        for (const std::string_view outer : std::span{names}.first(names.size() - 1)) {
            Json& inner = (*in)["properties"][std::string{outer}];
            if (inner.is_null()) inner = closed_object();
            in = &inner;
        }
        (*in)["properties"][std::string{names.back()}] = property;
        if (key.required) object["required"].push_back(key.name);
    }
    return object;
}

template <class Section>
Json object_of(Keys<Section> keys) {
    Json object = closed_object();
    return add_keys(object, keys);
}

Json tunnel() {
    Json object = object_of(tunnel_keys());
    object["properties"]["wrap"] = {{"type", "array"}, {"items", object_of(wrap_keys())}};
    return object;
}

// Faults of the layouts are told by what reads them; this is for editors.
Json flexible() {
    const Json address{{"type", Json::array({"string", "integer"})}};
    Json field = closed_object();
    field["properties"] = {{"name", {{"type", "string"}}},
                           {"type", {{"enum", {"u8", "i8", "u16", "i16", "u32", "i32", "f32"}}}},
                           {"scale", {{"type", "number"}}},
                           {"unit", {{"type", "string"}}}};
    field["required"] = Json::array({"name", "type"});
    Json object = closed_object();
    object["description"] = "the layout of a flexible message, for tools; anogated itself does not look inside";
    object["properties"] = {{"id", address}, {"source", address}, {"fields", {{"type", "array"}, {"items", field}}}};
    object["required"] = Json::array({"id", "fields"});
    return object;
}

Json link_of(const LinkKind& kind) {
    Json object = closed_object();
    object["description"] = kind.help;
    object["properties"]["kind"] = {{"const", kind.name}};
    object["required"] = Json::array({"kind"});
    return add_keys(object, link_keys(), kind.name);
}

}    // namespace

std::string config_schema() {
    Json kinds = Json::array();
    kinds.push_back({{"type", "string"}, {"description", "KIND:ADDRESS[,KEY=VALUE...]"}, {"pattern", "^[a-z-]+:.+"}});
    for (const LinkKind& kind : link_kinds()) kinds.push_back(link_of(kind));
    Json schema = closed_object();
    schema["properties"] = {{"$schema", {{"type", "string"}}},
                            {"gateway", object_of(gateway_keys())},
                            {"links", {{"type", "array"}, {"maxItems", 64}, {"items", {{"anyOf", kinds}}}}},
                            {"routes", {{"type", "array"}, {"items", object_of(route_keys())}}},
                            {"alias", {{"type", "array"}, {"items", object_of(alias_keys())}}},
                            {"tunnel", tunnel()},
                            {"gpio", {{"type", "array"}, {"items", object_of(gpio_keys())}}},
                            {"flexible", {{"type", "array"}, {"items", flexible()}}},
                            {"control", object_of(control_keys())},
                            {"log", object_of(log_keys())}};
    Json document{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "anogate configuration"}};
    document.update(schema);
    return document.dump(2) + "\n";
}

}    // namespace anogate
