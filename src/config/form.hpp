// The forms of values, one row each: how a value is parsed from text and JSON, how it is printed, and how the schema and the help
// describe it. The table is in form.cpp.
#pragma once
#include <config/value.hpp>

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct KeyFacts;

/// On the command line and in a LINK text every value is text.
enum class Form : std::uint8_t {
    boolean,
    integer,
    decimal,    // a number in thousandths
    address,    // a hardware id
    can_id,
    addresses,    // one hardware id, or a range
    duration,
    interval,    // a duration, or true or false
    size,
    choice,
    choice_or_link,    // one of the choices, or the name of a link
    text,
    endpoint,
    host,    // an endpoint, or a host name and a port
    networks,
    network,    // a single network
    ip,         // an IPv4 address, or one of the choices
    names,      // of links
    texts,      // a list of texts
    words,      // a list of texts that are not names of our links; joined by + in a LINK text
    line,       // of a GPIO chip: its number or its name
    silence,    // "silent" and a duration
    frames,     // ids, messages, classes
    senders,    // addresses and ranges of addresses
    limits,     // a JSON object: message → frames per second
};

/// A value as written: one word, or several if the form is a list; for a limit: the message and the rate.
using Words = std::vector<std::string>;

struct FormRow {
    Form form;
    bool is_joined = false;       // a list in JSON; in text its words are joined by +
    bool may_be_alone = false;    // in a LINK text the key alone means true
    /// The words of a JSON value; std::nullopt: it has the wrong type.
    std::optional<Words> (*words)(const nlohmann::json&);
    /// Sets the value and returns "", or returns the error.
    std::string (*read)(const KeyFacts&, const Words&, Value&);
    nlohmann::ordered_json (*print)(const KeyFacts&, const Value&);
    nlohmann::ordered_json (*schema)(const KeyFacts&);
    std::string (*expected)(const KeyFacts&);
    std::string (*placeholder)(const KeyFacts&);
};

const FormRow& row_of(Form form) noexcept;

/// Sets `value` and returns "", or returns the error.
std::string read_text(const KeyFacts& key, std::string_view text, Value& value);
std::string read_json(const KeyFacts& key, const nlohmann::json& json, Value& value);
/// std::nullopt for a value that is not set or is empty.
std::optional<nlohmann::ordered_json> printed(const KeyFacts& key, const Value& value);
/// The same, as text for a LINK.
std::optional<std::string> format_value(const KeyFacts& key, const Value& value);

/// For an error text: the value, or its type if it is long.
std::string format_json(const nlohmann::json& json);

}    // namespace anogate
