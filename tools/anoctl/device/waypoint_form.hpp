// The three formats of waypoint files.
#pragma once
#include <ano_json/frame_json.hpp>
#include <host/waypoints.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// "geojson", "qgc" or "json", by the extension; "json" for "-" and without an extension. Throws UsageError for other extensions.
std::string form_of_name(const std::string& file);
/// The format of the content of `file`. Throws UsageError, which names the file, if it is none of the three.
std::string form_of_content(const ano::Json& json, const std::string& file);

/// Clauses for the question: the effects of writing `waypoints` to a device that has `had` waypoints, numbered from 0: which are
/// overwritten, which remain (the protocol can't remove waypoints), which numbers the file omits. Empty: no such effects.
std::string overwriting_text(const std::vector<ano::host::Waypoint>& waypoints, std::size_t had);
/// A clause: which waypoints have no speed in the file. `waypoints`: those of its rows. Empty: all have a speed.
std::string speedless_text(const ano::Json& json, const std::string& form, const std::vector<ano::host::Waypoint>& waypoints);

}    // namespace anoctl
