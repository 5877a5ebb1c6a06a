#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <config/json_text.hpp>
#include <config/key_objects.hpp>
#include <gateway/ip.hpp>
#include <mavlink/mavlink_config.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <utility>

namespace anogate {

mavlink::StickSettings MavlinkDevice::sticks() const {
    mavlink::StickSettings settings;
    for (std::size_t i = 0; i < settings.accepts.size(); ++i)
        settings.accepts[i] = std::find(accept.begin(), accept.end(), mavlink::stick_input_names[i]) != accept.end();
    settings.hover_throttle = hover_throttle / 1000.0;
    settings.velocity_modes = velocity_modes;
    settings.attitude_modes = attitude_modes;
    std::copy_n(aux.begin(), std::min(aux.size(), settings.aux.size()), settings.aux.begin());
    return settings;
}

namespace {

using Json = nlohmann::ordered_json;
using nlohmann::json;

constexpr std::string_view mavlink_sections[] = {"devices", "log"};
constexpr MavlinkList device_lists[] = {
    {"velocity_modes", "[NUMBER, ...]", "the flight modes (0x06) in which it follows velocities (default: [2], position hold)"},
    {"attitude_modes", "[NUMBER, ...]", "the flight modes in which it follows attitudes (default: [0])"},
    {"aux", "[NUMBER, ...]", "channels 5 to 10, 1000 to 2000, for manual_control and rc_override"},
    {"funs", "[OBJECT, ...]",
     "what the byte `fun` of waypoints means to the device, as {\"kind\": \"hold\", \"fun\": 1, \"cmd\": [\"hold_s\", 0, 0, 0]}; "
     "kinds are waypoint, hold, take_off, land and return_home. Other items of missions are refused (default: waypoint 0, hold "
     "1)"},
};
constexpr char hold_time[] = "hold_s";

class MavlinkReader {
public:
    MavlinkReader(std::string file, MavlinkSettings& settings, ConfigErrors& errors)
        : file_{std::move(file)}, settings_{settings}, errors_{errors} {}

    void document(const json& document) {
        if (!key_objects::is_object(document, file_, errors_)) return;
        json own = json::object();
        for (const auto& [name, value] : document.items()) {
            const std::string where = at(file_, ano::pointer_step(name));
            if (name == "$schema") continue;
            if (name == "devices") devices(value, where);
            else if (name == "log") section(value, where, log_keys(), settings_.log);
            else if (find_key(mavlink_keys(), name) != nullptr) own[name] = value;
            else errors_.push_back({where, unknown(name)});
        }
        key_objects::read_keys(own, {file_.empty() ? "" : file_ + ": ", true}, list_of(mavlink_keys()), settings_, errors_);
    }

private:
    static std::string unknown(const std::string& name) {
        std::vector<std::string_view> known{std::begin(mavlink_sections), std::end(mavlink_sections)};
        for (const auto& key : mavlink_keys()) known.push_back(key.name);
        return "unknown key " + in_quotes(name) + ano::did_you_mean(name, known);
    }

    template <class Section>
    void section(const json& value, const std::string& where, Keys<Section> table, Section& into) {
        const KeyList<Section> list = list_of(table);
        if (key_objects::is_object(value, where, errors_, key_objects::of_keys(list)))
            key_objects::read_keys(value, {where, true}, list, into, errors_);
    }

    void devices(const json& value, const std::string& where) {
        if (!value.is_array()) return errors_.push_back({where, "must be a list [...], not " + format_json(value)});
        for (std::size_t i = 0; i < value.size(); ++i) {
            const std::string place = where + "/" + std::to_string(i);
            MavlinkDevice device;
            json object = value[i];
            if (object.is_object()) {
                numbers(object, device_lists[0].name, place, device.velocity_modes, 0, 0xFF);
                numbers(object, device_lists[1].name, place, device.attitude_modes, 0, 0xFF);
                numbers(object, device_lists[2].name, place, device.aux, 1000, 2000);
                if (object.contains("funs")) funs(object["funs"], place + "/funs", device);
                object.erase("funs");
            }
            section(object, place, mavlink_device_keys(), device);
            settings_.devices.push_back(std::move(device));
        }
    }

    template <class T>
    void numbers(json& object, std::string_view name, const std::string& where, std::vector<T>& into, std::uint64_t least,
                 std::uint64_t most) {
        const std::string key{name};
        if (!object.contains(key)) return;
        const json value = object[key];
        object.erase(key);
        const auto fits = [&](const json& one) {
            return one.is_number_unsigned() && one.get<std::uint64_t>() >= least && one.get<std::uint64_t>() <= most;
        };
        if (!value.is_array() || value.empty() || !std::all_of(value.begin(), value.end(), fits))
            return errors_.push_back({where + "/" + key, "must be a list of numbers from " + std::to_string(least) + " to " +
                                                             std::to_string(most) + ", not " + format_json(value)});
        into = value.get<std::vector<T>>();
    }

    void funs(const json& value, const std::string& where, MavlinkDevice& device) {
        if (!value.is_array()) return errors_.push_back({where, "must be a list [...], not " + format_json(value)});
        device.funs.clear();
        for (std::size_t i = 0; i < value.size(); ++i)
            if (const auto row = fun(value[i])) device.funs.push_back(*row);
            else
                errors_.push_back(
                    {where + "/" + std::to_string(i), R"(must be like {"kind": "hold", "fun": 1, "cmd": ["hold_s", 0, 0, 0]})"});
    }

    static std::optional<mavlink::FunRow> fun(const json& value) {
        const auto is_byte = [](const json& one) { return one.is_number_unsigned() && one.get<std::uint64_t>() <= 0xFF; };
        if (!value.is_object() || !value.contains("kind") || !value.contains("fun") || !is_byte(value["fun"]))
            return std::nullopt;
        const auto& kinds = mavlink::item_kind_names;
        const auto kind = std::find(std::begin(kinds), std::end(kinds),
                                    value["kind"].is_string() ? value["kind"].get<std::string>() : "");
        mavlink::FunRow row;
        const json bytes = value.value("cmd", json::array());
        if (kind == std::end(kinds) || !bytes.is_array() || bytes.size() > row.bytes.size()) return std::nullopt;
        row.kind = static_cast<mavlink::ItemKind>(kind - std::begin(kinds));
        row.fun = value["fun"].get<std::uint8_t>();
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            if (bytes[i] == hold_time) row.bytes[i].is_hold_time = true;
            else if (is_byte(bytes[i])) row.bytes[i].constant = bytes[i].get<std::uint8_t>();
            else return std::nullopt;
        }
        return row;
    }

    std::string file_;
    MavlinkSettings& settings_;
    ConfigErrors& errors_;
};

void check_device(const MavlinkDevice& device, const std::string& where, ConfigErrors& errors) {
    const mavlink::StickSettings sticks = device.sticks();
    using mavlink::StickInput;
    if ((sticks.accepts_input(StickInput::velocity) || sticks.accepts_input(StickInput::attitude)) && device.hover_throttle == 0)
        errors.push_back(
            {where, "'hover_throttle' is missing: velocity and attitude need the throttle at which the device hovers"});
    if (sticks.accepts_input(StickInput::manual_control) && device.aux.size() != sticks.aux.size())
        errors.push_back(
            {where, "'aux' must have 6 numbers: manual_control has no values for channels 5 to 10, which may select modes"});
}

Json fun_json(const mavlink::FunRow& row) {
    Json bytes = Json::array();
    for (const mavlink::ItemByte& byte : row.bytes) bytes.push_back(byte.is_hold_time ? Json(hold_time) : Json(byte.constant));
    return {{"kind", mavlink::item_kind_names[static_cast<std::size_t>(row.kind)]}, {"fun", row.fun}, {"cmd", bytes}};
}

Json numbers_schema(std::string_view help, int least, int most) {
    return {{"description", help},
            {"type", "array"},
            {"minItems", 1},
            {"items", {{"type", "integer"}, {"minimum", least}, {"maximum", most}}}};
}

Json funs_schema() {
    Json row = key_objects::closed_object();
    row["required"] = {"kind", "fun"};
    row["properties"]["kind"] = {{"enum", mavlink::item_kind_names}};
    row["properties"]["fun"] = {{"type", "integer"}, {"minimum", 0}, {"maximum", 255}};
    row["properties"]["cmd"] = {{"type", "array"}, {"maxItems", 4}, {"items", {{"type", {"integer", "string"}}}}};
    return {{"description", device_lists[3].help}, {"type", "array"}, {"items", row}};
}

}    // namespace

void read_mavlink_config(std::string_view text, const std::string& file, MavlinkSettings& settings, ConfigErrors& errors) {
    if (const auto document = parse_json(text, file, errors)) MavlinkReader{file, settings, errors}.document(*document);
}

void check_mavlink_settings(const MavlinkSettings& settings, ConfigErrors& errors) {
    if (settings.udp.empty() && settings.udp_listen.empty() && settings.tcp_listen.empty() && settings.serial.empty())
        errors.push_back({"", "no ground station: give --udp, --udp-listen, --tcp-listen or --serial"});
    for (const auto* list : {&settings.udp_listen, &settings.tcp_listen})
        for (const std::string& place : *list)
            if (!Endpoint::parse(place)) errors.push_back({"", in_quotes(place) + " must be ADDR:PORT, such as 0.0.0.0:14551"});
    for (const std::string& place : settings.udp)
        if (!Endpoint::parse(place)) errors.push_back({"", in_quotes(place) + " must be ADDR:PORT, such as 192.168.1.20:14550"});
    for (std::size_t i = 0; i < settings.devices.size(); ++i) {
        const MavlinkDevice& device = settings.devices[i];
        check_device(device, "devices/" + std::to_string(i), errors);
        for (std::size_t j = 0; j < i; ++j) {
            const MavlinkDevice& other = settings.devices[j];
            if (device.system == other.system)
                errors.push_back(
                    {"devices/" + std::to_string(i), "another device has the system id " + std::to_string(device.system)});
            if (device.address == other.address && (device.link == other.link || device.link.empty() || other.link.empty()))
                errors.push_back(
                    {"devices/" + std::to_string(i), "another entry is for the same device: give both a 'link', or remove one"});
        }
    }
}

std::string print_mavlink_config(const MavlinkSettings& settings) {
    Json document = Json::object();
    key_objects::print_keys(settings, list_of(mavlink_keys()), document);
    document["devices"] = Json::array();
    for (const MavlinkDevice& device : settings.devices) {
        Json object = Json::object();
        key_objects::print_keys(device, list_of(mavlink_device_keys()), object);
        object["velocity_modes"] = device.velocity_modes;
        object["attitude_modes"] = device.attitude_modes;
        if (!device.aux.empty()) object["aux"] = device.aux;
        object["funs"] = Json::array();
        for (const mavlink::FunRow& row : device.funs) object["funs"].push_back(fun_json(row));
        document["devices"].push_back(std::move(object));
    }
    document["log"] = Json::object();
    key_objects::print_keys(settings.log, list_of(log_keys()), document["log"]);
    return document.dump(2) + "\n";
}

std::string mavlink_config_schema() {
    Json schema = key_objects::closed_object();
    schema["properties"]["$schema"] = {{"type", "string"}};
    key_objects::add_keys(schema, list_of(mavlink_keys()));
    Json& properties = schema["properties"];
    Json device = key_objects::closed_object();
    key_objects::add_keys(device, list_of(mavlink_device_keys()));
    device["properties"]["velocity_modes"] = numbers_schema(device_lists[0].help, 0, 255);
    device["properties"]["attitude_modes"] = numbers_schema(device_lists[1].help, 0, 255);
    device["properties"]["aux"] = numbers_schema(device_lists[2].help, 1000, 2000);
    device["properties"]["funs"] = funs_schema();
    properties["devices"] = {{"type", "array"}, {"items", device}};
    Json log = key_objects::closed_object();
    properties["log"] = key_objects::add_keys(log, list_of(log_keys()));
    Json document{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "anogate-mavlink configuration"}};
    document.update(schema);
    return document.dump(2) + "\n";
}

std::span<const MavlinkList> mavlink_device_lists() noexcept { return device_lists; }

std::optional<MavlinkDevice> parse_mavlink_device(std::string_view text) {
    constexpr std::uint64_t last_address = 0xFE, last_system = 250;
    const std::size_t colon = text.find(':');
    if (colon == text.npos) return std::nullopt;
    const auto number = [](std::string_view part, std::uint64_t most) -> std::optional<std::uint8_t> {
        const auto parsed = ano::parse_number(part);
        const auto* whole = parsed ? std::get_if<std::uint64_t>(&*parsed) : nullptr;
        const auto* other = parsed ? std::get_if<std::int64_t>(&*parsed) : nullptr;
        const std::uint64_t value = whole != nullptr                 ? *whole
                                    : other != nullptr && *other > 0 ? static_cast<std::uint64_t>(*other)
                                                                     : 0;
        return value >= 1 && value <= most ? std::optional{static_cast<std::uint8_t>(value)} : std::nullopt;
    };
    const auto address = number(text.substr(0, colon), last_address), system = number(text.substr(colon + 1), last_system);
    if (!address || !system) return std::nullopt;
    MavlinkDevice device;
    device.address = *address;
    device.system = *system;
    return device;
}

}    // namespace anogate
