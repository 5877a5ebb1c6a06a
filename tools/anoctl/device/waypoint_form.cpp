#include "waypoint_form.hpp"

#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace anoctl {
namespace {

using ano::Json;
using WaypointNumbers = std::vector<std::size_t>;

// "0 to 2, 5 and 7"
std::string number_ranges(const WaypointNumbers& ascending) {
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < ascending.size();) {
        const std::size_t first = i;
        while (++i < ascending.size() && ascending[i] == ascending[i - 1] + 1) {}
        const std::size_t last = i - 1;
        parts.push_back(std::to_string(ascending[first]));
        if (last > first) parts.back() += (last > first + 1 ? " to " : " and ") + std::to_string(ascending[last]);
    }
    std::string text;
    for (std::size_t i = 0; i < parts.size(); ++i) text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
    return text;
}

bool names_speed(const Json& json, const std::string& form, std::size_t row) {
    if (form == "json") return at(json, "waypoints")[row].contains("spd");
    return at(at(json, "features")[row], "properties").contains("spd");
}

}    // namespace

std::string form_of_name(const std::string& file) {
    const std::string extension = std::filesystem::path{file}.extension().string();
    if (extension == ".geojson") return "geojson";
    if (extension == ".plan") return "qgc";
    if (extension.empty() || extension == ".json") return "json";
    throw UsageError{file + ": " + ano::in_quotes(extension) +
                     " is not a supported waypoint format; use .json, .geojson or .plan (QGroundControl), or --format"};
}

std::string form_of_content(const ano::Json& json, const std::string& file) {
    const std::string type = text_at(json, "type");
    if (type == "FeatureCollection" || type == "Feature") return "geojson";
    if (text_at(json, "fileType") == "Plan") return "qgc";
    if (json.is_object() && json.contains("waypoints")) return "json";
    throw UsageError{file + R"(: not a waypoint file; expected {"waypoints": [...]}, GeoJSON or a QGroundControl plan)"};
}

std::string overwriting_text(const std::vector<ano::host::Waypoint>& waypoints, std::size_t had) {
    WaypointNumbers over, stay, gaps;
    std::size_t wanted = 0;
    for (const ano::host::Waypoint& one : waypoints) wanted = std::max(wanted, one.num + std::size_t{1});
    for (std::size_t number = 0; number < std::max(wanted, had); ++number) {
        const bool is_written = std::any_of(waypoints.begin(), waypoints.end(),
                                            [&](const ano::host::Waypoint& one) { return one.num == number; });
        if (number < had) (is_written ? over : stay).push_back(number);
        else if (!is_written) gaps.push_back(number);
    }
    std::string text;
    if (had > 0) {
        text = "The device has " + plural(had, "waypoint") +
               (had > 1 ? " (0 to " + std::to_string(had - 1) + ")" : " (number 0)") + ": ";
        if (over.empty()) text += "none will be overwritten";
        else if (stay.empty()) text += std::string{had == 1 ? "it" : "all"} + " will be overwritten";
        else text += number_ranges(over) + " will be overwritten";
        if (!stay.empty())
            text += ", and " + number_ranges(stay) + (stay.size() == 1 ? " remains" : " remain") +
                    " (the protocol cannot remove waypoints)";
        text += ". ";
    }
    if (wanted < had)
        text += "To shorten the route, repeat the last point in the file until it has " + std::to_string(had) + ". ";
    if (!gaps.empty()) text += "The file has no waypoint " + number_ranges(gaps) + "; the device decides their content. ";
    return text;
}

std::string speedless_text(const Json& json, const std::string& form, const std::vector<ano::host::Waypoint>& waypoints) {
    WaypointNumbers without;
    for (std::size_t row = 0; row < waypoints.size(); ++row) {
        const bool has_one = form == "qgc" ? waypoints[row].num == 0 || waypoints[row].spd != 0 : names_speed(json, form, row);
        if (!has_one) without.push_back(waypoints[row].num);
    }
    if (without.empty()) return {};
    std::sort(without.begin(), without.end());
    return "The file has no speed for " + number_ranges(without) + " (counted from 0); 0 cm/s is written" +
           (form == "qgc" ? " because the plan does not set a speed before. " : ". ");
}

}    // namespace anoctl
