#include <ano_json/nearest.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/text.hpp>
#include <client/gateway_socket.hpp>
#include <ros2/command_text.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <iterator>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view command_keys[] = {"command", "values", "id"};

Json named(const CommandText& command) {
    Json json = Json::object();
    if (!command.id.empty()) json["id"] = command.id;
    if (!command.command.empty()) json["command"] = command.command;
    return json;
}

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}    // namespace

Expected<CommandText> parse_command(std::string_view text) {
    if (text.size() > CommandText::max_size) return Unexpected{std::string{"the text is longer than 4096 bytes"}};
    const auto json = ano::strict_json<Json>(text);
    if (!json || !json->is_object()) return Unexpected{std::string{R"(not a JSON object such as {"command": "TAKE_OFF"})"}};
    for (const auto& [key, value] : json->items())
        if (std::find(std::begin(command_keys), std::end(command_keys), key) == std::end(command_keys))
            return Unexpected{"unknown key " + ano::in_quotes(key) + ano::did_you_mean(key, command_keys)};
    CommandText command;
    const Json id = json->value("id", Json("")), name = json->value("command", Json{}),
               values = json->value("values", Json::array());
    if (!id.is_string() || id.get<std::string>().size() > CommandText::max_id)
        return Unexpected{std::string{"'id' must be text of at most 64 bytes"}};
    if (!name.is_string() || name.get<std::string>().empty())
        return Unexpected{std::string{"'command' must be the name of a command"}};
    if (!values.is_array()) return Unexpected{std::string{"'values' must be an array"}};
    command.id = id.get<std::string>();
    command.command = name.get<std::string>();
    command.body = Json{{"values", values}}.dump();
    return command;
}

std::string command_result(const CommandText& command, const http::Outcome& outcome) {
    constexpr unsigned success = 2;
    if (outcome.answer.status / 100 != success) return command_failure(command, fault_of(outcome));
    Json json = named(command);
    json["ok"] = true;
    const Json result = Json::parse(outcome.answer.body, nullptr, false);
    if (!result.is_discarded()) json["result"] = result;
    return text_of(json);
}

std::string command_failure(const CommandText& command, const std::string& error) {
    Json json = named(command);
    json["ok"] = false;
    json["error"] = error;
    return text_of(json);
}

}    // namespace anogate
