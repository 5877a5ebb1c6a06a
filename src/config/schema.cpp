#include <config/config.hpp>
#include <config/key_objects.hpp>
#include <config/link_kind.hpp>

#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using key_objects::add_keys;
using key_objects::closed_object;

template <class Section>
Json object_of(Keys<Section> keys) {
    Json object = closed_object();
    return add_keys(object, list_of(keys));
}

Json tunnel() {
    Json object = object_of(tunnel_keys());
    object["properties"]["wrap"] = {{"type", "array"}, {"items", object_of(wrap_keys())}};
    return object;
}

// Not strict: this is for editors. The reader of the layouts reports their errors.
Json flexible() {
    const Json address{{"type", Json::array({"string", "integer"})}};
    Json field = closed_object();
    field["properties"] = {{"name", {{"type", "string"}}},
                           {"type", {{"enum", {"u8", "i8", "u16", "i16", "u32", "i32", "f32"}}}},
                           {"count", {{"type", "integer"}, {"minimum", 1}, {"maximum", 65535}}},
                           {"scale", {{"type", "number"}}},
                           {"unit", {{"type", "string"}}}};
    field["required"] = Json::array({"name", "type"});
    Json object = closed_object();
    object["description"] = "the layout of a flexible message, for tools; anogated itself does not decode it";
    object["properties"] = {{"id", address},
                            {"source", address},
                            {"endian", {{"enum", {"little", "big"}}}},
                            {"when", address},
                            {"fields", {{"type", "array"}, {"items", field}}}};
    object["required"] = Json::array({"id", "fields"});
    return object;
}

Json link_of(const LinkKind& kind, LinkKinds kinds) {
    Json object = closed_object();
    object["description"] = kind.help;
    object["properties"]["kind"] = {{"const", kind.name}};
    object["required"] = Json::array({"kind"});
    return add_keys(object, keys_of(kind, kinds));
}

}    // namespace

std::string config_schema(LinkKinds kinds) {
    Json links = Json::array();
    links.push_back({{"type", "string"}, {"description", "KIND:ADDRESS[,KEY=VALUE...]"}, {"pattern", "^[a-z-]+:.+"}});
    for (const LinkKind* kind : kinds) links.push_back(link_of(*kind, kinds));
    Json schema = closed_object();
    schema["properties"] = {{"$schema", {{"type", "string"}}},
                            {"gateway", object_of(gateway_keys())},
                            {"links", {{"type", "array"}, {"maxItems", 64}, {"items", {{"anyOf", links}}}}},
                            {"routes", {{"type", "array"}, {"items", object_of(route_keys())}}},
                            {"alias", {{"type", "array"}, {"items", object_of(alias_keys())}}},
                            {"classes", {{"type", "array"}, {"items", object_of(class_keys())}}},
                            {"tunnel", tunnel()},
                            {"gpio", {{"type", "array"}, {"items", object_of(gpio_keys())}}},
                            {"flexible", {{"type", "array"}, {"items", flexible()}}},
                            {"control", object_of(control_keys())},
                            {"record", object_of(record_keys())},
                            {"log", object_of(log_keys())}};
    Json document{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "anogate configuration"}};
    document.update(schema);
    return document.dump(2) + "\n";
}

}    // namespace anogate
