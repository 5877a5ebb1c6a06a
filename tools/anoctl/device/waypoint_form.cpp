#include "waypoint_form.hpp"

#include <anoctl/gateway_json.hpp>

#include <nlohmann/json.hpp>

namespace anoctl {

std::string form_of_name(std::string_view file) {
    if (file.ends_with(".geojson")) return "geojson";
    return file.ends_with(".plan") ? "qgc" : "json";
}

std::string form_of_content(const ano::Json& json) {
    const std::string type = text_at(json, "type");
    if (type == "FeatureCollection" || type == "Feature") return "geojson";
    return text_at(json, "fileType") == "Plan" ? "qgc" : "json";
}

}    // namespace anoctl
