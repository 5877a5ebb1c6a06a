#include "command_values.hpp"
#include "typed_value.hpp"

#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/text/gateway_json.hpp>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <sstream>
#include <string_view>
#include <variant>

namespace anoctl {

using ano::Json;

namespace {

Json value_typed(const std::string& word, const std::string& type_name, const std::string& where) {
    if (const std::string misfit = misfit_of(word, type_name); !misfit.empty()) throw UsageError{where + misfit};
    const auto number = ano::parse_number(word);
    if (!number) throw UsageError{where + ano::in_quotes(word) + " is not a number"};
    return std::visit([](auto plain) { return Json(plain); }, *number);
}

std::uint8_t byte_in(const std::string& word, const std::string& cid) {
    const auto number = ano::parse_number(word);
    const Json json = number ? std::visit([](auto plain) { return Json(plain); }, *number) : Json{};
    const std::int64_t byte = json.is_number_integer() ? json.get<std::int64_t>() : -1;
    if (byte < 0 || byte > 0xFF) throw UsageError{"--cid " + ano::in_quotes(cid) + " must be three bytes, as in 16,0,5"};
    return static_cast<std::uint8_t>(byte);
}

}    // namespace

Json call_by_cid(const std::string& cid, const std::vector<std::string>& words) {
    Json bytes = Json::array(), values = Json::array();
    std::istringstream in{cid};
    for (std::string byte; std::getline(in, byte, ',');) bytes.push_back(byte_in(byte, cid));
    if (bytes.size() != 3 || cid.ends_with(',')) (void)byte_in("", cid);
    for (const std::string& word : words) {
        const std::string where = "value " + std::to_string(values.size() + 1) + ": ";
        const auto colon = word.find(':');
        if (colon == word.npos) values.push_back(value_typed(word, "", where));
        else values.push_back({{word.substr(0, colon), value_typed(word.substr(colon + 1), word.substr(0, colon), where)}});
    }
    return {{"cid", bytes}, {"values", values}};
}

const Json& command_called(const Json& commands, const std::string& word) {
    std::vector<std::string> names;
    const Json* found = nullptr;
    for (const Json& command : commands) {
        names.push_back(text_at(command, "name"));
        if (names.back() != word && text_at(command, "id") != word) continue;
        if (found != nullptr && text_at(*found, "id") != word)
            throw UsageError{"several commands are named " + ano::in_quotes(word) +
                             "; use the number shown by anoctl command list"};
        found = &command;
    }
    if (found != nullptr) return *found;
    throw UsageError{"the device has no command " + ano::in_quotes(word) +
                     ano::did_you_mean(word, std::vector<std::string_view>{names.begin(), names.end()}) +
                     "; to list the commands: anoctl command list"};
}

std::string command_usage(const Json& command) {
    std::string text = text_at(command, "name");
    for (const Json& type : at(command, "values")) text += " " + (type.is_string() ? type.get<std::string>() : "?");
    return text;
}

Json command_values(const Json& command, const std::vector<std::string>& words, bool states_type_7) {
    const Json& types = at(command, "values");
    if (words.size() != types.size())
        throw UsageError{text_at(command, "name") + " takes " + std::to_string(types.size()) +
                         (types.size() == 1 ? " value" : " values") + ", not " + std::to_string(words.size()) + ": " +
                         command_usage(command)};
    const auto type_of = [&](const Json& type) {
        const std::string name = type.is_string() ? type.get<std::string>() : "";
        return states_type_7 && (name == "u64" || name == "f32") ? "" : name;
    };
    Json values = Json::array();
    for (std::size_t i = 0; i < words.size(); ++i)
        values.push_back(
            value_typed(words[i], type_of(types[i]), text_at(command, "name") + ", value " + std::to_string(i + 1) + ": "));
    return values;
}

}    // namespace anoctl
