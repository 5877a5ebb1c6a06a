// The three forms of files with waypoints.
#pragma once
#include <ano_json/frame_json.hpp>
#include <host/waypoints.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// "geojson", "qgc" or "json", by the extension; "json" for "-" and without an extension. Throws UsageError for an unknown extension.
std::string form_of_name(const std::string& file);
/// The form of the content of `file`. Throws UsageError, with the name of the file, when it is none of the three.
std::string form_of_content(const ano::Json& json, const std::string& file);

/// Clauses before the question: the effect of writing these to a device that has `had` waypoints, numbered from 0: which are overwritten,
/// which stay (the protocol can't remove any), which numbers the file omits. Empty: no such effects.
std::string overwriting_text(const std::vector<ano::host::Waypoint>& waypoints, std::size_t had);
/// Such a clause: which waypoints have no speed in the file; `waypoints`: those of its rows. Empty: all have one.
std::string speedless_text(const ano::Json& json, const std::string& form, const std::vector<ano::host::Waypoint>& waypoints);

}    // namespace anoctl
