// The properties of a configuration key that do not depend on the type of its setting, and the texts of its errors.
#pragma once
#include <ano_json/text.hpp>
#include <config/form.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// A dot in the name is a nested object in JSON: "send.deny" is {"send": {"deny": []}}.
struct KeyFacts {
    std::string_view name;
    Form form{};
    std::string_view help;
    std::uint64_t min = 0, max = 0;    // of a number, in thousandths, ms or bytes depending on its form; of a text: its length in
                                       // bytes
    std::string_view choices{};        // "none|even|odd", in the order of the enumeration
    std::string_view kinds{};          // the uses of GPIO lines, or the group of link kinds, with this key; empty: all
    std::string_view option{};         // the command-line option that sets it: "--id"
    std::string_view stands_for{};     // the placeholder in help texts: "PATH"; empty: the one of the form
    bool required = false;
    bool is_local = false;             // an endpoint of this computer
    bool is_v4 = false;                // networks of IPv4 only: "any" is 0.0.0.0/0
    bool allows_host_names = false;    // host names are allowed besides networks or an IP address

    /// Whether GPIO lines of the use `kind` have this key. True for an empty `kind`.
    bool is_of(std::string_view kind) const;
};

/// A description of valid values: "a whole number from 1 to 20".
std::string expected(const KeyFacts& key);
/// "'baud' must be a whole number from 1 to 20, not X"; `given` is X, quoted by the caller if it is text.
std::string must_be(const KeyFacts& key, const std::string& given);
/// The placeholder for the value in a help text: NUMBER, none|even|odd.
std::string placeholder(const KeyFacts& key);
/// "unknown key 'bauds' (did you mean 'baud'?)", or "'baud' is not a key of udp, but of serial". `keys`: the keys of `kind`;
/// `owners`: the kinds that have a key `name`.
std::string unknown_key(std::string_view name, const std::vector<std::string_view>& keys, std::string_view kind,
                        const std::vector<std::string_view>& owners);

using ano::in_quotes;

/// The parts of `text` between separators; one empty part for an empty text.
std::vector<std::string_view> split(std::string_view text, char separator);

}    // namespace anogate
