// In which of the three forms a file of waypoints is.
#pragma once
#include <ano_json/frame_json.hpp>
#include <host/waypoints.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// "geojson", "qgc" or "json"; this for "-" and for a name without an extension. Throws UsageError for an extension that stands for none.
std::string form_of_name(const std::string& file);
/// Of a file that was read. Throws UsageError, with the name of the `file`, when it is none of them.
std::string form_of_content(const ano::Json& json, const std::string& file);

/// What writing these means to a device that has `had`, 0 and on, as clauses before the question: which are overwritten, which stay (the
/// protocol has no way to remove one), which the file leaves out. Empty: nothing is to be said.
std::string overwriting_text(const std::vector<ano::host::Waypoint>& waypoints, std::size_t had);
/// Which of them have no speed in the file, as such a clause; `waypoints` are those of its rows. Empty: all have.
std::string speedless_text(const ano::Json& json, const std::string& form, const std::vector<ano::host::Waypoint>& waypoints);

}    // namespace anoctl
