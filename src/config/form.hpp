// The ways in which values are written, one row each: what it may be in text and in JSON, how it is read and printed, and what
// schema and help say of it. The table stands in form.cpp.
#pragma once
#include <config/value.hpp>

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct KeyFacts;

/// On the command line and in a LINK text everything is text.
enum class Form : std::uint8_t {
    boolean,
    integer,
    decimal,    // a number in thousandths
    address,    // a hardware id
    can_id,
    addresses,    // one, or a range of them
    duration,
    interval,    // a duration, or whether at all
    size,
    choice,
    choice_or_link,    // one of the choices, or the name of a link
    text,
    endpoint,
    networks,
    network,    // one of them
    ip,         // an IPv4 address, or one of the choices
    names,      // of links
    texts,      // a list of them
    words,      // the same, which stand for something else than links of ours: in a LINK text joined by +
    line,       // of a GPIO chip: its number or its name
    silence,    // "silent" and a duration
    frames,     // ids, messages, classes
    senders,    // addresses and ranges of them
    limits,     // an object of its own: each of its keys names a message
};

/// A value as it was given: one word, or several where the form is a list; of a limit the message and the rate.
using Words = std::vector<std::string>;

struct FormRow {
    Form form;
    bool is_joined = false;       // a list in JSON; in text joined by +
    bool may_be_alone = false;    // the key alone means true in a LINK text
    /// The words of a JSON value; nothing when it is not of the right type.
    std::optional<Words> (*words)(const nlohmann::json&);
    /// What is wrong with the words, or nothing and the value.
    std::string (*read)(const KeyFacts&, const Words&, Value&);
    nlohmann::ordered_json (*print)(const KeyFacts&, const Value&);
    nlohmann::ordered_json (*schema)(const KeyFacts&);
    std::string (*expected)(const KeyFacts&);
    std::string (*placeholder)(const KeyFacts&);
};

const FormRow& row_of(Form form) noexcept;

/// What is wrong with `text`, or nothing and the value.
std::string read_text(const KeyFacts& key, std::string_view text, Value& value);
std::string read_json(const KeyFacts& key, const nlohmann::json& json, Value& value);
/// Nothing for a value that is not set, or is empty.
std::optional<nlohmann::ordered_json> printed(const KeyFacts& key, const Value& value);
/// The same as it is written in a LINK text.
std::optional<std::string> text_of(const KeyFacts& key, const Value& value);

/// For an error: the value, or what it is when it is not a short one.
std::string shown(const nlohmann::json& json);

}    // namespace anogate
