// The options and operands of a subcommand, independent of the parser (anoctl.cpp).
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace anoctl {

struct Option {
    /// Parses the word. Returns empty, or the reason why it is not valid.
    using Read = std::function<std::string(const std::string& word)>;
    /// The targets must live as long as the run. A bool is set if the option is given; a vector receives all words after the
    /// option.
    using Into = std::variant<bool*, std::string*, std::optional<std::string>*, std::vector<std::string>*, Read>;

    std::string name;    // "--from"; "link" for an operand
    Into into;
    std::string value;    // the placeholder in --help; empty for a flag
    std::string help;
    bool required = false;
    std::vector<std::string> excludes = {};    // names of options that can't be combined with it
};

using Options = std::vector<Option>;

}    // namespace anoctl
