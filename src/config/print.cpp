#include <config/config.hpp>
#include <config/keys.hpp>
#include <config/values.hpp>

#include <charconv>
#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

/// A value's text as JSON of the key's type.
Json json_of(const std::string& text, Form form) {
    switch (form) {
    case Form::boolean: return text == "true";
    case Form::integer:
    case Form::address: {
        std::uint64_t number = 0;
        std::from_chars(text.data(), text.data() + text.size(), number);
        return number;
    }
    case Form::networks: {
        if (text == "any") return text;
        Json list = Json::array();
        for (const std::string_view network : split(text, '+')) list.push_back(network);
        return list;
    }
    case Form::names: {
        Json list = Json::array();
        if (!text.empty())
            for (const std::string_view name : split(text, '\n')) list.push_back(name);
        return list;
    }
    case Form::line:
        if (const auto number = parse_number(text)) return *number;
        return text;
    case Form::frames:
    case Form::senders: {
        Json list = Json::array();
        for (const std::string_view word : split(text, '+')) list.push_back(word);
        return list;
    }
    case Form::limits: {
        Json object = Json::object();
        for (const std::string_view line : split(text, '\n')) {
            const std::size_t equals = line.find('=');
            object[std::string{line.substr(0, equals)}] = Json::parse(line.substr(equals + 1));
        }
        return object;
    }
    case Form::network:
    case Form::ip:
    case Form::silence:
    case Form::can_id:
    case Form::addresses:
    case Form::duration:
    case Form::interval:
    case Form::size:
    case Form::choice:
    case Form::choice_or_link:
    case Form::text:
    case Form::endpoint: return text;
    }
    return {};
}

template <class Section>
void print_keys(const Section& section, Keys<Section> keys, Json& into, std::string_view kind = {}) {
    for (const Key<Section>& key : keys) {
        const auto text = key.text_in(section);
        if (!text || text->empty() || !key.is_of(kind)) continue;
        Json* object = &into;
        const auto names = split(key.name, '.');
        for (const std::string_view outer : std::span{names}.first(names.size() - 1)) object = &(*object)[std::string{outer}];
        (*object)[std::string{names.back()}] = json_of(*text, key.form);
    }
}

template <class Section>
Json object_of(const Section& section, Keys<Section> keys) {
    Json object = Json::object();
    print_keys(section, keys, object);
    return object;
}

Json object_of(const LinkSettings& link) {
    Json object{{"name", link.name}, {"kind", link.kind}};
    print_keys(link, link_keys(), object, link.kind);
    return object;
}

Json object_of(const GpioSettings& line) {
    Json object = Json::object();
    print_keys(line, gpio_keys(), object, *find_key(gpio_keys(), "use")->text_in(line));
    return object;
}

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
    if (settings.tunnel) document["tunnel"] = object_of(*settings.tunnel);
    document["gpio"] = Json::array();
    for (const GpioSettings& line : settings.gpio) document["gpio"].push_back(object_of(line));
    document["flexible"] = Json::parse(settings.flexible);
    document["control"] = object_of(settings.control, control_keys());
    document["log"] = object_of(settings.log, log_keys());
    return document.dump(2) + "\n";
}

}    // namespace anogate
