// Parses the Prometheus text format of a gateway.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string_view>
#include <vector>

namespace anoctl {

/// {"name", "labels": {…}, "value"} for each sample; other lines are ignored.
std::vector<ano::Json> samples_of(std::string_view text);

}    // namespace anoctl
