// Waypoints as JSON, in the forms that programs know.
#pragma once
#include <host/waypoints.hpp>

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate {

enum class WaypointForm : std::uint8_t {
    plain,      // {"waypoints": [{"num", "lng", "lat" in degrees, "alt" in cm, "spd" in cm/s, "yaw", "fun", "cmd"}]}
    geojson,    // a FeatureCollection of points with the same beside; the third coordinate is metres
    qgc,        // a plan of QGroundControl: waypoints, changes of speed, and the home position, which is number 0
};
/// Nothing for a name that none has; an empty one is plain.
std::optional<WaypointForm> waypoint_form(std::string_view name);

nlohmann::ordered_json waypoints_json(std::span<const ano::host::Waypoint> waypoints, WaypointForm form);
/// What is wrong with it is a text.
std::variant<std::vector<ano::host::Waypoint>, std::string> waypoints_in(const nlohmann::ordered_json& json, WaypointForm form);

}    // namespace anogate
