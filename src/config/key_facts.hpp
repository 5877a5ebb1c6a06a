// What is known of a configuration key whatever it sets, and the words for its errors.
#pragma once
#include <ano_json/text.hpp>
#include <config/form.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// A key with a dot in its name is one of an object in JSON: "send.deny" is {"send": {"deny": []}}.
struct KeyFacts {
    std::string_view name;
    Form form{};
    std::string_view help;
    std::uint64_t least = 0, most = 0;    // of the number, thousandths, milliseconds, bytes; of a text: its length in bytes
    std::string_view choices{};           // "none|even|odd", in the order of the enumeration
    std::string_view kinds{};             // the uses of GPIO lines, or the sort of links, that have it; empty: all
    std::string_view option{};            // the command-line option that sets it: "--id"
    std::string_view stands_for{};        // what help texts put for the value: "PATH"; empty: what the form says
    bool required = false;
    bool is_local = false;    // of an endpoint: one of this computer
    bool is_v4 = false;       // of networks: IPv4 alone, for which any is 0.0.0.0/0

    /// Of a GPIO line's key: whether lines of this use have it. An empty one has every key.
    bool is_of(std::string_view kind) const;
};

/// What the value must be: "a whole number from 1 to 20".
std::string expected(const KeyFacts& key);
/// "'baud' must be a whole number from 1 to 20, not X"; `given` is the X, quoted where it needs it.
std::string must_be(const KeyFacts& key, const std::string& given);
/// What to put for the value in a help text: NUMBER, none|even|odd.
std::string placeholder(const KeyFacts& key);
/// "unknown key 'bauds' (did you mean 'baud'?)", or "'baud' is not a key of udp, but of serial": `keys` are those of `kind`,
/// `owners` the kinds that have one of this name.
std::string unknown_key(std::string_view name, const std::vector<std::string_view>& keys, std::string_view kind,
                        const std::vector<std::string_view>& owners);

using ano::in_quotes;

/// The pieces of `text` between separators; one empty piece for an empty text.
std::vector<std::string_view> split(std::string_view text, char separator);

}    // namespace anogate
