// In which of the three forms a file of waypoints is.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>

namespace anoctl {

/// "geojson", "qgc" or "json"; this for "-" and for a name without an extension. Throws UsageError for an extension that stands for none.
std::string form_of_name(const std::string& file);
/// Of a file that was read. Throws UsageError, with the name of the `file`, when it is none of them.
std::string form_of_content(const ano::Json& json, const std::string& file);

/// What writing so many waypoints (up to the highest number) means to a device that has `had`, as clauses before the question: the
/// protocol has no way to remove one. Empty: it had none.
std::string overwriting_text(std::size_t wanted, std::size_t had);

}    // namespace anoctl
