#include <ano_json/flexible_json.hpp>
#include <config/config.hpp>
#include <config/key_objects.hpp>
#include <config/link_kind.hpp>

#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using key_objects::print_keys;

template <class Section>
Json object_of(const Section& section, Keys<Section> keys, std::string_view kind = {}) {
    Json object = Json::object();
    print_keys(section, list_of(keys, kind), object);
    return object;
}

Json object_of(const LinkSettings& link) {
    Json object{{"name", link.name}, {"kind", link.kind->name}};
    print_keys(link, keys_of(*link.kind, {}), object);
    return object;
}

Json object_of(const GpioSettings& line) { return object_of(line, gpio_keys(), *find_key(gpio_keys(), "use")->text_in(line)); }

Json object_of(const TunnelSettings& tunnel) {
    Json object = object_of(tunnel, tunnel_keys());
    object["wrap"] = Json::array();
    for (const WrapSettings& rule : tunnel.wrap) object["wrap"].push_back(object_of(rule, wrap_keys()));
    return object;
}

}    // namespace

std::string print_config(const Settings& settings) {
    Json links = Json::array();
    for (const LinkSettings& link : settings.links) links.push_back(object_of(link));
    Json routes = Json::array();
    for (const RouteSettings& route : settings.routes) routes.push_back(object_of(route, route_keys()));
    Json document{{"gateway", object_of(settings.gateway, gateway_keys())}, {"links", links}, {"routes", routes}};
    document["alias"] = Json::array();
    for (const AliasSettings& alias : settings.aliases) document["alias"].push_back(object_of(alias, alias_keys()));
    document["classes"] = Json::array();
    for (const ClassSettings& of_id : settings.classes) document["classes"].push_back(object_of(of_id, class_keys()));
    if (settings.tunnel) document["tunnel"] = object_of(*settings.tunnel);
    document["gpio"] = Json::array();
    for (const GpioSettings& line : settings.gpio) document["gpio"].push_back(object_of(line));
    document["flexible"] = ano::flexible_to_json(settings.flexible);
    document["control"] = object_of(settings.control, control_keys());
    if (settings.record) document["record"] = object_of(*settings.record, record_keys());
    document["log"] = object_of(settings.log, log_keys());
    return document.dump(2) + "\n";
}

}    // namespace anogate
