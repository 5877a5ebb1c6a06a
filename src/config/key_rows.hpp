// Functions that create rows of keys: endpoint<own<UdpSettings>, &UdpSettings::peer>("address", "the peer's IP:PORT") | needed.
#pragma once
#include <config/keys.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace anogate::key_rows {

/// The first step to a field in the settings of one kind of link.
template <class Struct>
struct Own {
    Struct& operator()(LinkSettings& link) const { return link.as<Struct>(); }
    const Struct& operator()(const LinkSettings& link) const { return link.as<Struct>(); }
};
template <class Struct>
inline constexpr Own<Struct> own{};

template <class Class, class Member>
Class section_of(Member Class::*);
template <class Struct>
LinkSettings section_of(Own<Struct>);

/// The field at the end of the steps, applied one after the other.
template <class Object, class Step, class... Steps>
auto& reach(Object& object, Step step, Steps... steps) {
    const auto next = [&]() -> auto& {
        if constexpr (std::is_member_object_pointer_v<Step>) return object.*step;
        else return step(object);
    };
    if constexpr (sizeof...(Steps) == 0) return next();
    else return reach(next(), steps...);
}

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

/// `value` must have the type of the key's form, which must match the type of the field.
template <class Field>
void store(const KeyFacts& key, Value value, Field& field) {
    if constexpr (is_optional<Field>) {
        store(key, std::move(value), field.emplace());
    } else if constexpr (std::is_enum_v<Field>) {
        const auto choices = split(key.choices, '|');
        field = static_cast<Field>(std::find(choices.begin(), choices.end(), std::get<std::string>(value)) - choices.begin());
    } else if constexpr (std::is_integral_v<Field> && !std::is_same_v<Field, bool>) {
        field = static_cast<Field>(std::get<std::uint64_t>(value));
    } else {
        field = std::get<Field>(std::move(value));
    }
}

/// std::monostate (not set) for an empty optional or list, and for a number or text below the key's `min`.
template <class Field>
Value value_of(const KeyFacts& key, const Field& field) {
    if constexpr (is_optional<Field>) {
        return field ? value_of(key, *field) : Value{};
    } else if constexpr (std::is_enum_v<Field>) {
        return std::string{split(key.choices, '|')[static_cast<std::size_t>(field)]};
    } else if constexpr (std::is_same_v<Field, bool>) {
        return field;
    } else if constexpr (std::is_integral_v<Field>) {
        return field < key.min ? Value{} : Value{std::uint64_t{field}};
    } else if constexpr (std::is_same_v<Field, std::string>) {
        return field.size() < key.min ? Value{} : Value{field};
    } else {
        return field;
    }
}

/// A row for the field at the end of First and then Rest.
template <auto First, auto... Rest>
constexpr auto row(KeyFacts facts) {
    using Section = decltype(section_of(First));
    return Key<Section>{facts,
                        [](const KeyFacts& key, const Section& section) { return value_of(key, reach(section, First, Rest...)); },
                        [](const KeyFacts& key, Value value, Section& section) {
                            store(key, std::move(value), reach(section, First, Rest...));
                            return std::string{};
                        }};
}

template <auto... Path>
constexpr auto boolean(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::boolean, .help = help});
}
template <auto... Path>
constexpr auto integer(std::string_view name, std::uint64_t min, std::uint64_t max, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::integer, .help = help, .min = min, .max = max});
}
/// The field is in thousandths, and so are `min` and `max`.
template <auto... Path>
constexpr auto decimal(std::string_view name, std::uint64_t min, std::uint64_t max, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::decimal, .help = help, .min = min, .max = max});
}
template <auto... Path>
constexpr auto words(std::string_view name, std::uint64_t min, std::uint64_t max, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::words, .help = help, .min = min, .max = max});
}
template <auto... Path>
constexpr auto address(std::string_view name, std::uint64_t min, std::uint64_t max, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::address, .help = help, .min = min, .max = max});
}
template <auto... Path>
constexpr auto can_id(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::can_id, .help = help, .min = 0, .max = 0x1FFF'FFFF});
}
template <auto... Path>
constexpr auto duration(std::string_view name, std::uint64_t min, std::uint64_t max, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::duration, .help = help, .min = min, .max = max});
}
template <auto... Path>
constexpr auto size(std::string_view name, std::string_view help) {
    constexpr std::uint64_t max = std::uint64_t{1} << 50;
    return row<Path...>({.name = name, .form = Form::size, .help = help, .min = 0, .max = max});
}
template <auto... Path>
constexpr auto choice(std::string_view name, std::string_view choices, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::choice, .help = help, .choices = choices});
}
template <auto... Path>
constexpr auto text(std::string_view name, std::uint64_t min, std::uint64_t max, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::text, .help = help, .min = min, .max = max});
}
template <auto... Path>
constexpr auto frames(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::frames, .help = help});
}
template <auto... Path>
constexpr auto senders(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::senders, .help = help});
}
template <auto... Path>
constexpr auto endpoint(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::endpoint, .help = help});
}
template <auto... Path>
constexpr auto host(std::string_view name, std::string_view help) {
    return row<Path...>({.name = name, .form = Form::host, .help = help});
}

/// A list of networks in one field and a bool "any network" in another, both in the settings of one kind of link.
template <class Struct, bool Struct::*any, std::vector<Network> Struct::*list>
constexpr auto networks(std::string_view name, std::string_view help) {
    return Key<LinkSettings>{{.name = name, .form = Form::networks, .help = help},
                             [](const KeyFacts&, const LinkSettings& link) -> Value {
                                 const Struct& all = link.as<Struct>();
                                 return NetworkList{all.*any, all.*list, {}};
                             },
                             [](const KeyFacts&, Value value, LinkSettings& link) {
                                 auto& given = std::get<NetworkList>(value);
                                 link.as<Struct>().*any = given.any;
                                 link.as<Struct>().*list = std::move(given.networks);
                                 return std::string{};
                             }};
}

// Modifiers of a row: `row | flag`.

template <class Section>
constexpr Key<Section> operator|(Key<Section> key, auto change) {
    change(key);
    return key;
}
constexpr auto of(std::string_view kinds) {
    return [kinds](KeyFacts& key) { key.kinds = kinds; };
}
constexpr auto by(std::string_view option) {
    return [option](KeyFacts& key) { key.option = option; };
}
constexpr auto as(std::string_view placeholder) {
    return [placeholder](KeyFacts& key) { key.stands_for = placeholder; };
}
constexpr auto needed = [](KeyFacts& key) { key.required = true; };
constexpr auto local = [](KeyFacts& key) { key.is_local = true; };

inline constexpr std::uint64_t first_id = 1, last_id = 254;    // 0x00 and 0xFF are not ids of devices
inline constexpr std::uint64_t second = 1000, day = 24 * 3600 * second;
inline constexpr std::uint64_t max_name = 64, max_path = 4095, max_interface = 15;

}    // namespace anogate::key_rows
