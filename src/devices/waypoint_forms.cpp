#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <devices/waypoint_forms.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::host::Waypoint;

constexpr double cm = 100;
constexpr std::uint16_t to_the_target = 400;    // a value of yaw
// MAVLink numbers in such plans.
constexpr int nav_waypoint = 16, change_speed = 178, above_home = 3;
constexpr std::pair<int, const char*> other_items[] = {{17, "a circling"},         {18, "a circling"}, {19, "a circling"},
                                                       {20, "a return to launch"}, {21, "a landing"},  {22, "a takeoff"}};

constexpr std::string_view keys[] = {"num", "lng", "lat", "alt", "spd", "yaw", "fun", "cmd"};
// Names that other programs use for these keys.
constexpr std::pair<std::string_view, std::string_view> other_names[] = {
    {"lon", "lng"}, {"long", "lng"}, {"longitude", "lng"}, {"height", "alt"}, {"speed", "spd"}, {"heading", "yaw"}};

/// Thrown in this file only; becomes the error text.
struct Wrong {
    std::string what;
};

// Counts from 0, like other programs and the numbers of waypoints.
std::string place_in_file(const char* what, std::size_t i) {
    return std::string{what} + ' ' + std::to_string(i) + " (counted from 0)";
}

/// " (did you mean 'alt'?)" for another name of a key or a mistyped one.
std::string meant_by(std::string_view key) {
    for (const auto& [other, ours] : other_names)
        if (key == other) return " (did you mean '" + std::string{ours} + "'?)";
    return ano::did_you_mean(key, keys);
}

/// Rejects unknown keys: if a mistyped "alt" were ignored, the height would be 0. `others_may_be`: rejects only keys similar to
/// known ones.
void refuse_strangers(const Json& object, bool others_may_be, const std::string& where) {
    for (const auto& [key, value] : object.items()) {
        if (std::find(std::begin(keys), std::end(keys), key) != std::end(keys)) continue;
        const std::string meant = meant_by(key);
        if (!others_may_be || !meant.empty()) throw Wrong{where + ": unknown key " + ano::in_quotes(key) + meant};
    }
}

double number_in(const Json& object, const char* key, const std::string& where) {
    if (!object.contains(key) || !object[key].is_number()) throw Wrong{where + ": '" + key + "' must be a number"};
    return object[key].get<double>();
}

template <class Whole>
Whole whole(double value, const std::string& what) {
    if (!(value >= double{std::numeric_limits<Whole>::min()} && value <= double{std::numeric_limits<Whole>::max()}))
        throw Wrong{what + " is out of range, " + std::to_string(std::numeric_limits<Whole>::min()) + " to " +
                    std::to_string(std::numeric_limits<Whole>::max())};
    if (value != std::round(value)) throw Wrong{what + " is not whole"};
    return static_cast<Whole>(value);
}

template <class Whole>
void read_field(const Json& object, const char* key, Whole& into, const std::string& where) {
    if (object.contains(key)) into = whole<Whole>(number_in(object, key, where), where + ": '" + key + "'");
}

Json properties_of(const Waypoint& w) { return {{"spd", w.spd}, {"yaw", w.yaw}, {"fun", w.fun}, {"cmd", w.cmd}}; }

void read_properties(const Json& object, Waypoint& w, const std::string& where) {
    read_field(object, "num", w.num, where);
    read_field(object, "alt", w.alt, where);
    read_field(object, "spd", w.spd, where);
    read_field(object, "yaw", w.yaw, where);
    read_field(object, "fun", w.fun, where);
    if (!object.contains("cmd")) return;
    const Json& cmd = object["cmd"];
    if (!cmd.is_array() || cmd.size() != w.cmd.size()) throw Wrong{where + ": 'cmd' must be four bytes"};
    for (std::size_t i = 0; i < w.cmd.size(); ++i) {
        if (!cmd[i].is_number()) throw Wrong{where + ": 'cmd' must be four bytes"};
        w.cmd[i] = whole<std::uint8_t>(cmd[i].get<double>(), where + ": 'cmd'");
    }
}

const Json& array_in(const Json& json, const char* key) {
    if (!json.is_object() || !json.contains(key) || !json[key].is_array())
        throw Wrong{"'" + std::string{key} + "' must be an array"};
    return json[key];
}

void add(std::vector<Waypoint>& all, const Waypoint& w, const std::string& where) {
    const auto same = [&](const Waypoint& one) { return one.num == w.num; };
    if (std::any_of(all.begin(), all.end(), same)) throw Wrong{where + ": duplicate number " + std::to_string(w.num)};
    all.push_back(w);
}

std::uint8_t next_number(const std::vector<Waypoint>& all) {
    if (all.size() > ano::host::last_waypoint)
        throw Wrong{"there are more than " + std::to_string(all.size()) + " waypoints: the last number of the protocol is " +
                    std::to_string(ano::host::last_waypoint)};
    return static_cast<std::uint8_t>(all.size());
}

std::vector<Waypoint> from_plain(const Json& json) {
    std::vector<Waypoint> all;
    for (const Json& row : array_in(json, "waypoints")) {
        const std::string where = place_in_file("waypoint", all.size());
        if (!row.is_object()) throw Wrong{where + " must be an object"};
        refuse_strangers(row, false, where);
        Waypoint w;
        w.num = next_number(all);
        w.lng = number_in(row, "lng", where);
        w.lat = number_in(row, "lat", where);
        if (!row.contains("alt")) throw Wrong{where + ": 'alt' is missing, its height in cm"};
        read_properties(row, w, where);
        add(all, w, where);
    }
    return all;
}

std::vector<Waypoint> from_geojson(const Json& json) {
    std::vector<Waypoint> all;
    for (const Json& feature : array_in(json, "features")) {
        const std::string where = place_in_file("feature", all.size());
        const Json geometry = feature.is_object() ? feature.value("geometry", Json{}) : Json{};
        if (!geometry.is_object() || geometry.value("type", Json{}) != "Point") throw Wrong{where + " is not a point"};
        const Json at = geometry.value("coordinates", Json::array());
        if (!at.is_array() || at.size() < 2 || !at[0].is_number() || !at[1].is_number() || (at.size() > 2 && !at[2].is_number()))
            throw Wrong{where + ": 'coordinates' must be longitude, latitude and metres"};
        Waypoint w;
        w.num = next_number(all);
        w.lng = at[0].get<double>();
        w.lat = at[1].get<double>();
        if (at.size() > 2) w.alt = whole<std::int32_t>(std::round(at[2].get<double>() * cm), where + ": the height");
        const Json properties = feature.value("properties", Json{});
        if (properties.is_object()) {
            refuse_strangers(properties, true, where);
            read_properties(properties, w, where);
        }
        if (at.size() < 3 && !(properties.is_object() && properties.contains("alt")))
            throw Wrong{where + " has no height: add metres as the third of 'coordinates', or 'alt' in cm to its properties"};
        add(all, w, where);
    }
    return all;
}

double place(const Json& array, std::size_t i, const std::string& where) {
    if (!array.is_array() || array.size() <= i || !array[i].is_number()) throw Wrong{where + " has no position"};
    return array[i].get<double>();
}

Waypoint from_item(const Json& params, std::uint16_t speed, const std::string& where) {
    Waypoint w;
    w.lat = place(params, 4, where);
    w.lng = place(params, 5, where);
    w.alt = whole<std::int32_t>(std::round(place(params, 6, where) * cm), where + ": the height");
    w.spd = speed;
    w.yaw = to_the_target;
    if (params[3].is_number())
        w.yaw = whole<std::uint16_t>(std::fmod(std::fmod(std::round(params[3].get<double>()), 360) + 360, 360), where + ": yaw");
    return w;
}

std::string misfit_of_item(int command) {
    const auto* const known = std::find_if(std::begin(other_items), std::end(other_items),
                                           [&](const auto& one) { return one.first == command; });
    const bool is_known = known != std::end(other_items);
    return " is " +
           (is_known ? std::string{known->second} + " (" + std::to_string(command) + ")" : std::string{"something else"}) +
           ", but devices support only waypoints (16) and speed changes (178): delete it from the plan" +
           (is_known ? ", and use a device command instead" : "");
}

// Rejects other items of a plan, which waypoints of the protocol can't express.
std::vector<Waypoint> from_qgc(const Json& json) {
    const Json mission = json.is_object() ? json.value("mission", Json{}) : Json{};
    const Json& items = array_in(mission, "items");
    std::vector<Waypoint> all;
    Waypoint home;
    const Json at = mission.value("plannedHomePosition", Json{});
    home.lat = place(at, 0, "'plannedHomePosition'");
    home.lng = place(at, 1, "'plannedHomePosition'");
    home.alt = whole<std::int32_t>(std::round(place(at, 2, "'plannedHomePosition'") * cm), "the height of home");
    all.push_back(home);
    std::uint16_t speed = 0;
    std::size_t i = 0;
    for (const Json& item : items) {
        const std::string where = place_in_file("item", i++);
        const int command = item.is_object() && item.contains("command") && item["command"].is_number_integer()
                                ? item["command"].get<int>()
                                : -1;
        const Json params = item.is_object() ? item.value("params", Json::array()) : Json::array();
        if (command == change_speed) {
            speed = whole<std::uint16_t>(std::round(place(params, 1, where) * cm), where + ": the speed");
        } else if (command == nav_waypoint) {
            Waypoint w = from_item(params, speed, where);
            w.num = next_number(all);
            all.push_back(w);
        } else {
            throw Wrong{where + misfit_of_item(command)};
        }
    }
    return all;
}

Json item_json(int command, int number, Json params) {
    return {{"type", "SimpleItem"}, {"command", command}, {"frame", command == nav_waypoint ? above_home : 2},
            {"autoContinue", true}, {"doJumpId", number}, {"params", std::move(params)}};
}

Json to_qgc(std::span<const Waypoint> waypoints) {
    Json items = Json::array(), home = Json::array({0, 0, 0});
    std::uint16_t speed = 0;
    int number = 0;
    for (const Waypoint& w : waypoints) {
        if (w.num == 0) {
            home = {w.lat, w.lng, w.alt / cm};
            continue;
        }
        if (w.spd != speed) items.push_back(item_json(change_speed, ++number, {1, w.spd / cm, -1, 0, 0, 0, 0}));
        speed = w.spd;
        const Json yaw = w.yaw < 360 ? Json(w.yaw) : Json(nullptr);
        items.push_back(item_json(nav_waypoint, ++number, {0, 0, 0, yaw, w.lat, w.lng, w.alt / cm}));
    }
    return {{"fileType", "Plan"},
            {"version", 1},
            {"groundStation", "QGroundControl"},
            {"mission",
             {{"version", 2},
              {"firmwareType", 0},
              {"vehicleType", 2},
              {"cruiseSpeed", 15},
              {"hoverSpeed", 5},
              {"plannedHomePosition", home},
              {"items", items}}},
            {"geoFence", {{"version", 2}, {"circles", Json::array()}, {"polygons", Json::array()}}},
            {"rallyPoints", {{"version", 2}, {"points", Json::array()}}}};
}

Json to_geojson(std::span<const Waypoint> waypoints) {
    Json features = Json::array();
    for (const Waypoint& w : waypoints) {
        Json properties{{"num", w.num}};
        properties.update(properties_of(w));
        features.push_back({{"type", "Feature"},
                            {"geometry", {{"type", "Point"}, {"coordinates", {w.lng, w.lat, w.alt / cm}}}},
                            {"properties", std::move(properties)}});
    }
    return {{"type", "FeatureCollection"}, {"features", std::move(features)}};
}

Json to_plain(std::span<const Waypoint> waypoints) {
    Json rows = Json::array();
    for (const Waypoint& w : waypoints) {
        Json row{{"num", w.num}, {"lng", w.lng}, {"lat", w.lat}, {"alt", w.alt}};
        row.update(properties_of(w));
        rows.push_back(std::move(row));
    }
    return {{"waypoints", std::move(rows)}};
}

}    // namespace

std::optional<WaypointForm> waypoint_form(std::string_view name) {
    if (name.empty() || name == "json") return WaypointForm::plain;
    if (name == "geojson") return WaypointForm::geojson;
    return name == "qgc" ? std::optional{WaypointForm::qgc} : std::nullopt;
}

Json waypoints_json(std::span<const Waypoint> waypoints, WaypointForm form) {
    if (form == WaypointForm::geojson) return to_geojson(waypoints);
    return form == WaypointForm::qgc ? to_qgc(waypoints) : to_plain(waypoints);
}

std::variant<std::vector<Waypoint>, std::string> waypoints_in(const Json& json, WaypointForm form) {
    try {
        if (form == WaypointForm::geojson) return from_geojson(json);
        return form == WaypointForm::qgc ? from_qgc(json) : from_plain(json);
    } catch (const Wrong& wrong) {
        return wrong.what;
    }
}

}    // namespace anogate
