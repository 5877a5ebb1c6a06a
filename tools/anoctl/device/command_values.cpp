#include "command_values.hpp"
#include "typed_value.hpp"

#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/gateway_json.hpp>

#include <nlohmann/json.hpp>

#include <string_view>
#include <variant>

namespace anoctl {

using ano::Json;

namespace {

Json value_typed(const std::string& word, const std::string& type_name, const std::string& where) {
    if (const std::string misfit = misfit_of(word, type_name); !misfit.empty()) throw UsageError{where + misfit};
    const auto number = ano::parse_number(word);
    if (!number) throw UsageError{where + ano::in_quotes(word) + " is no number"};
    return std::visit([](auto plain) { return Json(plain); }, *number);
}

}    // namespace

const Json& command_called(const Json& commands, const std::string& word) {
    std::vector<std::string> names;
    const Json* found = nullptr;
    for (const Json& command : commands) {
        names.push_back(text_at(command, "name"));
        if (names.back() != word && text_at(command, "id") != word) continue;
        if (found != nullptr && text_at(*found, "id") != word)
            throw UsageError{"several commands are called " + ano::in_quotes(word) +
                             ": say its number, anoctl command list has them"};
        found = &command;
    }
    if (found != nullptr) return *found;
    throw UsageError{"the device has no command " + ano::in_quotes(word) +
                     ano::did_you_mean(word, std::vector<std::string_view>{names.begin(), names.end()}) +
                     "; anoctl command list has them"};
}

std::string command_usage(const Json& command) {
    std::string text = text_at(command, "name");
    for (const Json& type : at(command, "values")) text += " " + (type.is_string() ? type.get<std::string>() : "?");
    return text;
}

Json command_values(const Json& command, const std::vector<std::string>& words) {
    const Json& types = at(command, "values");
    if (words.size() != types.size())
        throw UsageError{text_at(command, "name") + " takes " + std::to_string(types.size()) +
                         (types.size() == 1 ? " value" : " values") + ", not " + std::to_string(words.size()) + ": " +
                         command_usage(command)};
    Json values = Json::array();
    for (std::size_t i = 0; i < words.size(); ++i)
        values.push_back(value_typed(words[i], types[i].is_string() ? types[i].get<std::string>() : "",
                                     text_at(command, "name") + ", value " + std::to_string(i + 1) + ": "));
    return values;
}

}    // namespace anoctl
