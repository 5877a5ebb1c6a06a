// What a subcommand takes from the command line; who reads that (anoctl.cpp) is another matter.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace anoctl {

struct Option {
    /// Takes the word, or says what is wrong with it.
    using Read = std::function<std::string(const std::string& word)>;
    /// What is pointed to lives as long as the run. A bool is true when the option is given, a vector takes every word behind it.
    using Into = std::variant<bool*, std::string*, std::optional<std::string>*, std::vector<std::string>*, Read>;

    std::string name;    // "--from"; "link" for a word that is known by its place
    Into into;
    std::string value;    // what --help calls it; empty for a flag
    std::string help;
    bool required = false;
    std::vector<std::string> excludes = {};    // by name: these are not given together with it
};

using Options = std::vector<Option>;

}    // namespace anoctl
