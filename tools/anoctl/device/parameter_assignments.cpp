#include "parameter_assignments.hpp"
#include "typed_value.hpp"

#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/text/gateway_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <string_view>

namespace anoctl {

using ano::Json;

std::vector<Assignment> assignments(const std::vector<std::string>& words) {
    if (words.size() == 2 && words[0].find('=') == std::string::npos) return {{words[0], words[1]}};
    std::vector<Assignment> found;
    for (const std::string& word : words) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos || equals == 0)
            throw UsageError{ano::in_quotes(word) + " is no NAME=VALUE; one parameter is NAME VALUE as well"};
        found.push_back({word.substr(0, equals), word.substr(equals + 1)});
    }
    if (found.empty()) throw UsageError{"what? anoctl param set NAME VALUE, or NAME=VALUE..."};
    return found;
}

const Json& parameter_called(const Json& parameters, const std::string& word) {
    std::vector<std::string> names;
    const Json* found = nullptr;
    for (const Json& row : parameters) {
        names.push_back(text_at(row, "name"));
        if (names.back() != word || word.empty()) continue;
        if (found != nullptr) throw Failure{"several parameters have the name " + ano::in_quotes(word) + ": say its number"};
        found = &row;
    }
    if (found != nullptr) return *found;
    const auto numbered = std::find_if(parameters.begin(), parameters.end(),
                                       [&](const Json& row) { return text_at(row, "id") == word; });
    if (numbered != parameters.end()) return *numbered;
    throw Failure{"unknown parameter " + ano::in_quotes(word) +
                  ano::did_you_mean(word, std::vector<std::string_view>{names.begin(), names.end()})};
}

void check(const std::vector<Assignment>& wanted, const Json& parameters) {
    std::vector<std::string> seen;
    for (const auto& [word, value] : wanted) {
        const Json& row = parameter_called(parameters, word);
        const std::string id = text_at(row, "id"), name = text_at(row, "name");
        if (std::find(seen.begin(), seen.end(), id) != seen.end()) throw Failure{name + " is there twice"};
        seen.push_back(id);
        if (const std::string misfit = misfit_of(value, text_at(row, "type"), row.value("mul", 1)); !misfit.empty())
            throw Failure{name + ": " + misfit};
    }
}

}    // namespace anoctl
