#include <ano_json/compact_json.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/text.hpp>
#include <foxglove/foxglove_messages.hpp>

#include <nlohmann/json.hpp>

#include <limits>
#include <utility>

namespace anogate::foxglove {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t max_question_id = 256;    // bytes

std::optional<std::uint32_t> number_in(const Json& json) {
    if (!json.is_number_unsigned()) return std::nullopt;
    const auto number = json.get<std::uint64_t>();
    if (number > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
    return static_cast<std::uint32_t>(number);
}

/// The list with this name; nullptr: not found.
const Json* list_in(const Json& object, const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_array() ? &*found : nullptr;
}

Wrong no_list(std::string_view op, std::string_view name) {
    return {"'" + std::string{op} + "' needs a list '" + std::string{name} + "'"};
}

ClientMessage read_subscribe(const Json& json) {
    const Json* const list = list_in(json, "subscriptions");
    if (list == nullptr) return no_list("subscribe", "subscriptions");
    Subscribe request;
    for (const Json& one : *list) {
        const bool is_object = one.is_object();
        const auto id = is_object && one.contains("id") ? number_in(one["id"]) : std::nullopt;
        const auto channel = is_object && one.contains("channelId") ? number_in(one["channelId"]) : std::nullopt;
        if (!id || !channel) return Wrong{"a subscription needs 'id' and 'channelId', integers of at most 32 bits"};
        request.subscriptions.push_back({*id, *channel});
    }
    return request;
}

ClientMessage read_unsubscribe(const Json& json) {
    const Json* const list = list_in(json, "subscriptionIds");
    if (list == nullptr) return no_list("unsubscribe", "subscriptionIds");
    Unsubscribe request;
    for (const Json& one : *list) {
        const auto id = number_in(one);
        if (!id) return Wrong{"'subscriptionIds' must be integers of at most 32 bits"};
        request.ids.push_back(*id);
    }
    return request;
}

/// std::nullopt: not a list of texts. A missing list counts as empty.
std::optional<std::vector<std::string>> names_in(const Json& json) {
    std::vector<std::string> names;
    if (!json.contains("parameterNames")) return names;
    const Json* const list = list_in(json, "parameterNames");
    if (list == nullptr) return std::nullopt;
    for (const Json& one : *list) {
        if (!one.is_string()) return std::nullopt;
        names.push_back(one.get<std::string>());
    }
    return names;
}

const Wrong no_names{"'parameterNames' must be a list of texts"};

ClientMessage read_get_parameters(const Json& json) {
    auto names = names_in(json);
    if (!names) return no_names;
    GetParameters request{std::move(*names), {}};
    const auto id = json.find("id");
    if (id == json.end() || id->is_null()) return request;
    if (!id->is_string() || id->get_ref<const std::string&>().size() > max_question_id)
        return Wrong{"the 'id' of a request must be text of at most " + std::to_string(max_question_id) + " bytes"};
    request.id = id->get<std::string>();
    return request;
}

ClientMessage read_watch_parameters(const Json& json) {
    auto names = names_in(json);
    if (!names) return no_names;
    return WatchParameters{std::move(*names), false};
}

ClientMessage read_unwatch_parameters(const Json& json) {
    auto names = names_in(json);
    if (!names) return no_names;
    return WatchParameters{std::move(*names), true};
}

// Writing is supported only by the control interface, where programs identify themselves.
ClientMessage refuse_to_write(const Json& json) {
    return Wrong{ano::in_quotes(json["op"].get_ref<const std::string&>()) + " is not supported: this interface is read-only"};
}

ClientMessage refuse_graph(const Json&) {
    return Wrong{"the connection graph is not supported; see /status and /routes on this port"};
}

struct Operation {
    std::string_view name;
    ClientMessage (*read)(const Json& json);
};
constexpr Operation operations[] = {
    {"subscribe", read_subscribe},
    {"unsubscribe", read_unsubscribe},
    {"getParameters", read_get_parameters},
    {"subscribeParameterUpdates", read_watch_parameters},
    {"unsubscribeParameterUpdates", read_unwatch_parameters},
    {"setParameters", refuse_to_write},
    {"advertise", refuse_to_write},
    {"unadvertise", refuse_to_write},
    {"subscribeConnectionGraph", refuse_graph},
    {"unsubscribeConnectionGraph", refuse_graph},
};

template <class Number>
void append_number(std::string& bytes, Number number) {
    for (std::size_t i = 0; i < sizeof number; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xFF);
}

}    // namespace

ClientMessage read(std::string_view text) {
    constexpr std::size_t most_values = 4096;    // of 1000 subscriptions
    const auto parsed = ano::json_body(text, "the message", most_values);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return Wrong{*wrong};
    const Json json = std::get<nlohmann::ordered_json>(parsed);
    if (!json.is_object() || !json.contains("op") || !json["op"].is_string())
        return Wrong{"a message must be an object with 'op'"};
    const auto& op = json["op"].get_ref<const std::string&>();
    for (const Operation& operation : operations)
        if (operation.name == op) return operation.read(json);
    return Wrong{"unknown 'op' " + ano::in_quotes(op)};
}

std::string server_info(const ServerInfo& server) {
    return ano::compact_json(Json{{"op", "serverInfo"},
                                  {"name", server.name},
                                  {"capabilities", {"parameters", "parametersSubscribe"}},
                                  {"metadata", Json::object()},
                                  {"sessionId", server.session}});
}

std::string advertise(std::span<const Channel> channels) {
    Json list = Json::array();
    for (const Channel& channel : channels)
        list.push_back({{"id", channel.id},
                        {"topic", channel.topic},
                        {"encoding", channel.encoding},
                        {"schemaName", channel.schema_name},
                        {"schema", channel.schema},
                        {"schemaEncoding", channel.schema_encoding}});
    return ano::compact_json(Json{{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string unadvertise(std::span<const std::uint32_t> channels) {
    Json list = Json::array();
    for (const std::uint32_t channel : channels) list.push_back(channel);
    return ano::compact_json(Json{{"op", "unadvertise"}, {"channelIds", std::move(list)}});
}

std::string status(Level level, std::string_view words) {
    return ano::compact_json(Json{{"op", "status"}, {"level", static_cast<unsigned>(level)}, {"message", words}});
}

std::string parameter_values(std::span<const Parameter> parameters, const std::optional<std::string>& id) {
    Json list = Json::array();
    for (const Parameter& parameter : parameters) {
        Json one{{"name", parameter.name}, {"value", Json::parse(parameter.value, nullptr, false)}};
        if (one["value"].is_number_float()) one["type"] = "float64";    // because other programs write 5.0 as 5
        list.push_back(std::move(one));
    }
    Json json{{"op", "parameterValues"}, {"parameters", std::move(list)}};
    if (id) json["id"] = *id;
    return ano::compact_json(json);
}

std::string message_data(std::uint32_t subscription, std::uint64_t time_ns, std::string_view payload) {
    constexpr char opcode = 1;
    constexpr std::size_t head = 13;
    std::string bytes;
    bytes.reserve(head + payload.size());
    bytes += opcode;
    append_number(bytes, subscription);
    append_number(bytes, time_ns);
    return bytes.append(payload);
}

}    // namespace anogate::foxglove
