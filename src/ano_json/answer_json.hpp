// Durations and text in the answers of the daemon.
#pragma once
#include <ano/time.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace anogate {

/// Seconds, rounded down to whole milliseconds.
double in_seconds(ano::Duration d);

/// As ano::json_line().
std::string line_of(nlohmann::ordered_json json);

}    // namespace anogate
