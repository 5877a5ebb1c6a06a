// Objects of a configuration in JSON by their tables of keys: reading, printing, and the schema.
#pragma once
#include <ano_json/json_pointer.hpp>
#include <config/config.hpp>
#include <config/json_text.hpp>
#include <config/keys.hpp>

#include <nlohmann/json.hpp>

#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace anogate::key_objects {

/// `keys`: the keys it may have, as " of level, file"; empty if there are too many.
inline bool is_object(const nlohmann::json& value, const std::string& where, ConfigErrors& errors, const std::string& keys = {}) {
    if (!value.is_object()) errors.push_back({where, "must be an object {...}" + keys + ", not " + format_json(value)});
    return value.is_object();
}

/// " of allow, deny": the keys whose names begin with `inside`, such as "send.".
template <class Section>
std::string of_keys(const KeyList<Section>& list, std::string_view inside = {}) {
    std::string names;
    for (const Key<Section>* key : list.keys)
        if (key->name.starts_with(inside)) names.append(names.empty() ? " of " : ", ").append(key->name.substr(inside.size()));
    return names;
}

/// The form of "send.deny" in a file: {"send": {"deny": ...}}.
inline std::string nested(const std::string& name) {
    const std::size_t dot = name.find('.');
    return printable("\"" + name.substr(0, dot) + "\": {\"" + name.substr(dot + 1) + "\": ...}");
}

/// One entry of a limit, {"0x01": 50}.
template <class Section>
std::string read_entry(const Key<Section>& key, const std::string& name, const nlohmann::json& rate, Section& section) {
    if (!rate.is_number()) return in_quotes(name) + " must be a number of frames per second, not " + format_json(rate);
    return key.set_limit(name, rate.dump(), section);
}

/// The error for an unknown key.
template <class Section>
std::string unknown_name(const KeyList<Section>& list, const std::string& name, const std::string& full) {
    const std::string object_of = full.substr(0, full.find('.'));
    const bool dotted = name.find('.') != name.npos && (list.has_object(object_of) || object_of == "limit");
    return dotted ? "unknown key " + in_quotes(name) + ": in a file, write " + nested(full) : list.unknown(full);
}

/// Reads all keys of `object` into `section`, except `but`. `inside` is the prefix of the names in the table: "send.".
template <class Section>
void read_keys(const nlohmann::json& object, const Origin& origin, const KeyList<Section>& list, Section& section,
               ConfigErrors& errors, std::string_view but = {}, const std::string& inside = {}) {
    for (const auto& [name, value] : object.items()) {
        if (!but.empty() && name == but) continue;
        const auto where = origin.where + ano::pointer_step(name);
        const std::string full = inside + name;
        const Key<Section>* key = name.find('.') == name.npos ? list.find(full) : nullptr;
        std::string error;
        if (key == nullptr && list.has_object(full)) {
            if (is_object(value, where, errors, of_keys(list, full + ".")))
                read_keys(value, {where, true}, list, section, errors, but, full + ".");
        } else if (key == nullptr) {
            error = unknown_name(list, name, full);
        } else if (key->form == Form::limits) {
            if (!is_object(value, where, errors)) continue;
            for (const auto& [entry, rate] : value.items())
                if (std::string wrong = read_entry(*key, entry, rate, section); !wrong.empty())
                    errors.push_back({where + ano::pointer_step(entry), std::move(wrong)});
        } else {
            Value read;
            error = read_json(*key, value, read);
            if (error.empty()) error = key->put(*key, std::move(read), section);
        }
        if (!error.empty()) errors.push_back({where, std::move(error)});
    }
    if (!inside.empty()) return;
    for (const Key<Section>* key : list.keys)
        if (key->required && !object.contains(key->name))
            errors.push_back({origin.where, in_quotes(key->name) + " is missing" +
                                                (key->form == Form::choice ? ", " + expected(*key) : "") + ": " +
                                                std::string{key->help}});
}

/// Adds the values of `section` that are set.
template <class Section>
void print_keys(const Section& section, const KeyList<Section>& list, nlohmann::ordered_json& into) {
    for (const Key<Section>* key : list.keys) {
        auto value = printed(*key, key->get(*key, section));
        if (!value) continue;
        nlohmann::ordered_json* object = &into;
        const auto names = split(key->name, '.');
        for (const std::string_view outer : std::span{names}.first(names.size() - 1)) object = &(*object)[std::string{outer}];
        (*object)[std::string{names.back()}] = *std::move(value);
    }
}

/// The schema of an object without keys, which allows no others.
inline nlohmann::ordered_json closed_object() {
    return {{"type", "object"}, {"additionalProperties", false}, {"properties", nlohmann::ordered_json::object()}};
}

template <class Section>
nlohmann::ordered_json& add_keys(nlohmann::ordered_json& object, const KeyList<Section>& list) {
    for (const Key<Section>* key : list.keys) {
        nlohmann::ordered_json property{{"description", key->help}};
        property.update(row_of(key->form).schema(*key));
        nlohmann::ordered_json* in = &object;
        const auto names = split(key->name, '.');
        for (const std::string_view outer : std::span{names}.first(names.size() - 1)) {
            nlohmann::ordered_json& inner = (*in)["properties"][std::string{outer}];
            if (inner.is_null()) inner = closed_object();
            in = &inner;
        }
        (*in)["properties"][std::string{names.back()}] = property;
        if (key->required) object["required"].push_back(key->name);
    }
    return object;
}

}    // namespace anogate::key_objects
