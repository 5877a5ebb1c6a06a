// How a field of the settings is read from text and written, by its type. For the table of keys alone.
#pragma once
#include <config/frame_words.hpp>
#include <config/key_facts.hpp>
#include <config/values.hpp>
#include <gateway/settings.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace anogate {

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

/// Each returns what is wrong with `text`, or nothing.
std::string read_text(const KeyFacts& key, std::string_view text, std::string& field);
std::string read_endpoint(const KeyFacts& key, std::string_view text, EndpointSpec& field);
std::string read_duration(const KeyFacts& key, std::string_view text, Duration& field);
std::string read_boolean(const KeyFacts& key, std::string_view text, bool& field);
std::string read_number(const KeyFacts& key, std::string_view text, std::uint64_t& field);
std::string read_ranges(const KeyFacts& key, std::string_view text, std::vector<ByteRange>& field);
std::string read_choice(const KeyFacts& key, std::string_view text, std::size_t& field);

template <class Field>
std::string read_field(const KeyFacts& key, std::string_view text, Field& field) {
    const auto by_way_of = [&](auto value, auto read) {
        std::string error = read(key, text, value);
        if (error.empty()) field = static_cast<Field>(value);
        return error;
    };
    if constexpr (is_optional<Field>) {
        return by_way_of(typename Field::value_type{}, read_field<typename Field::value_type>);
    } else if constexpr (std::is_same_v<Field, bool>) {
        return read_boolean(key, text, field);
    } else if constexpr (std::is_enum_v<Field>) {
        return by_way_of(std::size_t{}, read_choice);
    } else if constexpr (std::is_integral_v<Field>) {
        return by_way_of(std::uint64_t{}, read_number);
    } else if constexpr (std::is_same_v<Field, Duration>) {
        return read_duration(key, text, field);
    } else if constexpr (std::is_same_v<Field, EndpointSpec>) {
        return read_endpoint(key, text, field);
    } else if constexpr (std::is_same_v<Field, std::vector<ByteRange>>) {
        return read_ranges(key, text, field);
    } else {
        return read_text(key, text, field);
    }
}

/// Nothing for a field that is not set: an empty optional, a number or a text below what the key may have.
template <class Field>
std::optional<std::string> write_field(const KeyFacts& key, const Field& field) {
    if constexpr (is_optional<Field>) {
        return field ? write_field(key, *field) : std::nullopt;
    } else if constexpr (std::is_same_v<Field, bool>) {
        return field ? "true" : "false";
    } else if constexpr (std::is_enum_v<Field>) {
        return std::string{split(key.choices, '|')[static_cast<std::size_t>(field)]};
    } else if constexpr (std::is_integral_v<Field>) {
        if (field < key.least) return std::nullopt;
        if (key.form == Form::can_id) return can_id_text(field);
        return key.form == Form::size ? size_text(field) : std::to_string(field);
    } else if constexpr (std::is_same_v<Field, Duration>) {
        return duration_text(field);
    } else if constexpr (std::is_same_v<Field, EndpointSpec>) {
        return field.text();
    } else if constexpr (std::is_same_v<Field, std::vector<ByteRange>>) {
        return field.empty() ? std::nullopt : std::optional{ranges_text(field)};
    } else {
        if (field.size() < key.least) return std::nullopt;
        return field;
    }
}

}    // namespace anogate
