// In which of the three forms a file of waypoints is.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>

namespace anoctl {

/// "geojson", "qgc" or "json".
std::string form_of_name(std::string_view file);
std::string form_of_content(const ano::Json& json);

}    // namespace anoctl
