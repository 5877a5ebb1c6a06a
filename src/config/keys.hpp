// Every key of the configuration is one row, and stands nowhere else: the JSON file, LINK texts, command-line options,
// --print-config, --help and the JSON Schema are loops over these rows.
#pragma once
#include <config/key_facts.hpp>
#include <gateway/settings.hpp>

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

template <class Section>
struct Key : KeyFacts {
    std::optional<std::string> (*write)(const KeyFacts&, const Section&) = nullptr;
    std::string (*read)(const KeyFacts&, std::string_view, Section&) = nullptr;

    /// The value in `section` as text; nothing when it is not set.
    std::optional<std::string> text_in(const Section& section) const { return write(*this, section); }
    /// Sets it and returns nothing, or says what is wrong with `text` and changes nothing.
    std::string set(std::string_view text, Section& section) const { return read(*this, text, section); }
};

template <class Section>
using Keys = std::span<const Key<Section>>;

Keys<GatewaySettings> gateway_keys() noexcept;
Keys<LinkSettings> link_keys() noexcept;
Keys<RouteSettings> route_keys() noexcept;
Keys<AliasSettings> alias_keys() noexcept;
/// But for "wrap", a list of objects with the wrap_keys().
Keys<TunnelSettings> tunnel_keys() noexcept;
Keys<WrapSettings> wrap_keys() noexcept;
/// The uses are their kinds.
Keys<GpioSettings> gpio_keys() noexcept;
Keys<ControlSettings> control_keys() noexcept;
Keys<LogSettings> log_keys() noexcept;

/// The row of `name`, for a link's key the one that `kind` has; nullptr when there is none.
template <class Section>
const Key<Section>* find_key(Keys<Section> keys, std::string_view name, std::string_view kind = {}) {
    for (const Key<Section>& key : keys)
        if (key.name == name && key.is_of(kind)) return &key;
    return nullptr;
}

/// Whether `name` is an object of keys: "send" of "send.deny".
template <class Section>
bool is_object_of_keys(Keys<Section> keys, std::string_view name, std::string_view kind = {}) {
    for (const Key<Section>& key : keys)
        if (key.is_of(kind) && key.name.starts_with(name) && key.name.substr(name.size()).starts_with('.')) return true;
    return false;
}

template <class Section>
std::string unknown_key_of(Keys<Section> keys, std::string_view name, std::string_view kind = {}) {
    std::vector<const KeyFacts*> facts;
    for (const Key<Section>& key : keys) facts.push_back(&key);
    return unknown_key(name, facts, kind);
}

}    // namespace anogate
