// How the daemon's answers write durations and text.
#pragma once
#include <ano/time.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace anogate {

/// Seconds, to the millisecond.
double in_seconds(ano::Duration d);

/// As ano::json_line().
std::string line_of(nlohmann::ordered_json json);

}    // namespace anogate
