#include "waypoint_form.hpp"

#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/gateway_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace anoctl {
namespace {

// "the first", "the first 3"
std::string several(const std::string& which, std::size_t number) {
    return "the " + which + (number == 1 ? "" : " " + std::to_string(number));
}

}    // namespace

std::string form_of_name(const std::string& file) {
    const std::string extension = std::filesystem::path{file}.extension().string();
    if (extension == ".geojson") return "geojson";
    if (extension == ".plan") return "qgc";
    if (extension.empty() || extension == ".json") return "json";
    throw UsageError{file + ": " + ano::in_quotes(extension) +
                     " is no form of waypoints; .json, .geojson and .plan (QGroundControl) are, or say it by --format"};
}

std::string form_of_content(const ano::Json& json, const std::string& file) {
    const std::string type = text_at(json, "type");
    if (type == "FeatureCollection" || type == "Feature") return "geojson";
    if (text_at(json, "fileType") == "Plan") return "qgc";
    if (json.is_object() && json.contains("waypoints")) return "json";
    throw UsageError{file + R"(: it is none of the forms of waypoints: {"waypoints": [...]}, GeoJSON, a plan of QGroundControl)"};
}

std::string overwriting_text(std::size_t wanted, std::size_t had) {
    if (had == 0) return {};
    std::string text = "It has " + std::to_string(had) + (had == 1 ? " waypoint" : " waypoints") + ": ";
    if (wanted >= had) return text + "overwritten " + (had == 1 ? "is this one. " : "are all of them. ");
    const std::size_t rest = had - wanted;
    return text + several("first", wanted) + (wanted == 1 ? " is" : " are") + " overwritten, and " + several("last", rest) +
           (rest == 1 ? " stays" : " stay") + " as " + (rest == 1 ? "it is" : "they are") +
           ", for the protocol has no way to remove one. To end the route sooner, repeat the last point of the file until it "
           "has " +
           std::to_string(had) + ". ";
}

}    // namespace anoctl
