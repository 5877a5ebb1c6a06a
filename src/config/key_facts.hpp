// What is known of a configuration key whatever it sets, and the words for its errors.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// How a value is written. A key with a dot in its name is one of an object in JSON: "send.deny" is {"send": {"deny": []}}.
/// On the command line and in a LINK text everything is text. In JSON a boolean and an integer
/// are themselves, an address and a CAN id are a number or text, networks are a list, and all else is text.
enum class Form : std::uint8_t {
    boolean,
    integer,
    address,    // a hardware id
    can_id,
    addresses,    // one, or a range of them
    duration,
    interval,    // a duration, or whether at all; in JSON a boolean or text
    size,
    choice,
    choice_or_link,    // one of the choices, or the name of a link
    text,
    endpoint,
    networks,
    network,    // one of them
    ip,         // an IPv4 address, or one of the choices
    names,      // of links; as text, one a line
    line,       // of a GPIO chip: its number or its name
    silence,    // "silent" and a duration
    frames,     // ids, messages, classes; joined by + as text, a list in JSON
    senders,    // addresses and ranges of them, in the same way
    limits,     // an object of its own: each of its keys names a message; as text "NAME=RATE", one a line
};

struct KeyFacts {
    std::string_view name;
    Form form{};
    std::string_view help;
    std::uint64_t least = 0, most = 0;    // of the number, milliseconds, bytes; of a text: its length in bytes
    std::string_view choices{};           // "none|even|odd", in the order of the enumeration
    std::string_view kinds{};             // of a link's key: the kinds that have it, "serial pty"; empty: all
    std::string_view option{};            // the command-line option that sets it: "--id"
    std::string_view stands_for{};        // what help texts put for the value: "PATH"; empty: what the form says
    bool required = false;

    /// Of a link's key: whether links of `kind` have it. An empty kind has every key.
    bool is_of(std::string_view kind) const;
};

/// What the value must be: "a whole number from 1 to 20".
std::string expected(const KeyFacts& key);
/// "'baud' must be a whole number from 1 to 20, not X"; `given` is the X, quoted where it needs it.
std::string must_be(const KeyFacts& key, const std::string& given);
/// What to put for the value in a help text: NUMBER, none|even|odd.
std::string placeholder(const KeyFacts& key);
/// "unknown key 'bauds' (did you mean 'baud'?)", or "'baud' is not a key of udp, but of serial".
std::string unknown_key(std::string_view name, std::span<const KeyFacts* const> keys, std::string_view kind);

/// `text` in single quotes, fit to be shown in a line.
std::string in_quotes(std::string_view text);
/// The pieces of `text` between separators; one empty piece for an empty text.
std::vector<std::string_view> split(std::string_view text, char separator);

}    // namespace anogate
