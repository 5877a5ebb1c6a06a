// Each key of the configuration is defined once, as a row of a table. The JSON file, LINK texts, command-line options,
// --print-config, --help and the JSON Schema are loops over these rows. The rows of one kind of link are in the file of that
// kind.
#pragma once
#include <config/key_facts.hpp>
#include <gateway/settings.hpp>

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

template <class Section>
struct Key : KeyFacts {
    Value (*get)(const KeyFacts&, const Section&) = nullptr;
    std::string (*put)(const KeyFacts&, Value, Section&) = nullptr;

    /// The value in `section` as text; std::nullopt: it is not set.
    std::optional<std::string> text_in(const Section& section) const { return format_value(*this, get(*this, section)); }
    /// Sets it and returns "", or returns the error for `text` and changes nothing.
    std::string set(std::string_view text, Section& section) const {
        Value value;
        std::string error = read_text(*this, text, value);
        return error.empty() ? put(*this, std::move(value), section) : error;
    }
    /// For Form::limits: adds the limit of one message. Returns the same as set().
    std::string set_limit(std::string_view message, std::string_view rate, Section& section) const {
        Value value;
        std::string error = row_of(form).read(*this, {std::string{message}, std::string{rate}}, value);
        return error.empty() ? put(*this, std::move(value), section) : error;
    }
};

template <class Section>
using Keys = std::span<const Key<Section>>;

Keys<GatewaySettings> gateway_keys() noexcept;
/// The keys of all kinds of links, except `rate` and `latency` (only kinds that may be paced), `gap` and `frame_gap` (streams of
/// bytes), `pack` and `mtu` (only datagrams). keys_of() in link_kind.hpp returns all keys of one kind.
Keys<LinkSettings> common_link_keys() noexcept;
Keys<RouteSettings> route_keys() noexcept;
Keys<AliasSettings> alias_keys() noexcept;
Keys<ClassSettings> class_keys() noexcept;
/// Without "wrap", which is a list of objects with the wrap_keys().
Keys<TunnelSettings> tunnel_keys() noexcept;
Keys<WrapSettings> wrap_keys() noexcept;
/// Their KeyFacts::kinds are uses of a line.
Keys<GpioSettings> gpio_keys() noexcept;
Keys<ControlSettings> control_keys() noexcept;
Keys<RecordSettings> record_keys() noexcept;
Keys<LogSettings> log_keys() noexcept;

/// The keys that an object may have, and the error for other names.
template <class Section>
struct KeyList {
    std::vector<const Key<Section>*> keys;
    std::function<std::string(std::string_view)> unknown;

    /// nullptr: there is none with that name.
    const Key<Section>* find(std::string_view name) const {
        for (const Key<Section>* key : keys)
            if (key->name == name) return key;
        return nullptr;
    }
    /// Whether `name` is an object that contains keys: "send" of "send.deny".
    bool has_object(std::string_view name) const {
        for (const Key<Section>* key : keys)
            if (key->name.starts_with(name) && key->name.substr(name.size()).starts_with('.')) return true;
        return false;
    }
};

template <class Section>
KeyList<Section> list_of(Keys<Section> keys, std::string_view kind = {}) {
    KeyList<Section> list;
    for (const Key<Section>& key : keys)
        if (key.is_of(kind)) list.keys.push_back(&key);
    list.unknown = [keys, kind = std::string{kind}](std::string_view name) {
        std::vector<std::string_view> usable, owners;
        for (const Key<Section>& key : keys) {
            if (key.is_of(kind)) usable.push_back(key.name);
            else if (key.name == name) owners = split(key.kinds, ' ');
        }
        return unknown_key(name, usable, kind, owners);
    };
    return list;
}

template <class Section>
const Key<Section>* find_key(Keys<Section> keys, std::string_view name) {
    for (const Key<Section>& key : keys)
        if (key.name == name) return &key;
    return nullptr;
}

}    // namespace anogate
