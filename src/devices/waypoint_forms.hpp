// Waypoints as JSON, in the formats of several programs.
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
    geojson,    // a FeatureCollection of points with the same properties; the third coordinate is in metres
    qgc,        // a plan of QGroundControl: waypoints, speed changes, and the home position as number 0
};
/// An empty name means plain; std::nullopt: unknown name.
std::optional<WaypointForm> waypoint_form(std::string_view name);

nlohmann::ordered_json waypoints_json(std::span<const ano::host::Waypoint> waypoints, WaypointForm form);
/// The waypoints, or the error as text.
std::variant<std::vector<ano::host::Waypoint>, std::string> waypoints_in(const nlohmann::ordered_json& json, WaypointForm form);

}    // namespace anogate
