#include <ano/hex.hpp>
#include <http/client/percent_encoded.hpp>
#include <mavlink/vehicle_requests.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace anogate::mavlink {
namespace {

using Json = nlohmann::json;

std::string device_target(std::uint8_t address, const std::string& rest) { return "/devices/" + ano::hex_byte(address) + rest; }

Json number_json(const CommandNumber& number) {
    if (ano::is_integer(number.type)) return static_cast<std::int64_t>(std::llround(number.value));
    return number.value;
}

std::optional<ano::Number> number_of(const Json& json) {
    if (json.is_number_unsigned()) return ano::Number{json.get<std::uint64_t>()};
    if (json.is_number_integer()) return ano::Number{json.get<std::int64_t>()};
    return json.is_number() ? std::optional{ano::Number{json.get<double>()}} : std::nullopt;
}

}    // namespace

DeviceRequest call_request(std::uint8_t address, const DeviceCommand& command) {
    Json values = Json::array();
    for (const CommandNumber& number : command.values) {
        if (command.cid) values.push_back({{std::string{name_of(number.type)}, number_json(number)}});
        else values.push_back(number_json(number));
    }
    if (command.cid)
        return {"POST", device_target(address, "/commands/by-cid?while_connected"),
                Json{{"cid", *command.cid}, {"values", values}}.dump()};
    return {"POST", device_target(address, "/commands/" + http::percent_encoded(command.name) + "?while_connected"),
            Json{{"values", values}}.dump()};
}

DeviceRequest parameters_request(std::uint8_t address) { return {"GET", device_target(address, "/parameters"), ""}; }

DeviceRequest parameter_request(std::uint8_t address, const std::string& name, const ano::Number& value) {
    const Json number = std::visit([](auto n) { return Json(n); }, value);
    return {"PUT", device_target(address, "/parameters/" + http::percent_encoded(name) + "?while_connected"),
            Json{{"value", number}}.dump()};
}

DeviceRequest waypoints_request(std::uint8_t address) { return {"GET", device_target(address, "/waypoints"), ""}; }

DeviceRequest put_waypoints_request(std::uint8_t address, const std::vector<Waypoint>& waypoints) {
    Json rows = Json::array();
    for (const Waypoint& w : waypoints)
        rows.push_back({{"num", w.num},
                        {"lng", w.lng},
                        {"lat", w.lat},
                        {"alt", w.alt},
                        {"spd", w.spd},
                        {"yaw", w.yaw},
                        {"fun", w.fun},
                        {"cmd", w.cmd}});
    return {"PUT", device_target(address, "/waypoints?while_connected"), Json{{"waypoints", rows}}.dump()};
}

bool is_success(const http::Outcome& outcome) noexcept {
    constexpr unsigned success = 2;
    return outcome.answer.status / 100 == success;
}

Result result_of(const http::Outcome& outcome) noexcept {
    constexpr unsigned not_found = 404, conflict = 409, unprocessable = 422, busy = 503;
    if (is_success(outcome)) return Result::accepted;
    switch (outcome.answer.status) {
    case not_found: return Result::unsupported;
    case conflict:
    case unprocessable: return Result::denied;
    case busy: return Result::temporarily_rejected;
    default: return Result::failed;
    }
}

std::optional<std::vector<DeviceParameter>> parameters_in(const std::string& body) {
    const Json json = Json::parse(body, nullptr, false);
    if (!json.is_object() || !json.contains("parameters") || !json["parameters"].is_array()) return std::nullopt;
    std::vector<DeviceParameter> all;
    for (const Json& row : json["parameters"]) {
        if (!row.is_object() || !row.contains("name") || !row["name"].is_string()) continue;
        const std::string type = row.contains("type") && row["type"].is_string() ? row["type"].get<std::string>() : "";
        DeviceParameter parameter{row["name"].get<std::string>(), ano::Type::text, std::nullopt};
        const auto name = std::find(ano::type_names.begin(), ano::type_names.end(), type);
        if (name != ano::type_names.end()) parameter.type = static_cast<ano::Type>(name - ano::type_names.begin());
        if (row.contains("value")) parameter.value = number_of(row["value"]);
        all.push_back(std::move(parameter));
    }
    return all;
}

std::optional<ano::Number> stored_value_in(const std::string& body) {
    const Json json = Json::parse(body, nullptr, false);
    return json.is_object() && json.contains("stored") ? number_of(json["stored"]) : std::nullopt;
}

std::optional<std::vector<Waypoint>> waypoints_in(const std::string& body) {
    const Json json = Json::parse(body, nullptr, false);
    if (!json.is_object() || !json.contains("waypoints") || !json["waypoints"].is_array()) return std::nullopt;
    std::vector<Waypoint> all;
    try {
        for (const Json& row : json["waypoints"]) {
            Waypoint w;
            w.num = row.at("num").get<std::uint8_t>();
            w.lng = row.at("lng").get<double>();
            w.lat = row.at("lat").get<double>();
            w.alt = row.at("alt").get<std::int32_t>();
            w.spd = row.at("spd").get<std::uint16_t>();
            w.yaw = row.at("yaw").get<std::uint16_t>();
            w.fun = row.at("fun").get<std::uint8_t>();
            w.cmd = row.at("cmd").get<std::array<std::uint8_t, 4>>();
            all.push_back(w);
        }
    } catch (const Json::exception&) {
        return std::nullopt;
    }
    return all;
}

}    // namespace anogate::mavlink
