// How the daemon's answers write durations and text.
#pragma once
#include <ano/time.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace anogate {

/// Seconds, to the millisecond.
double in_seconds(ano::Duration d);

/// A line. Names and errors may hold any byte (a path can): shown as U+FFFD where they are not UTF-8.
std::string line_of(const nlohmann::ordered_json& json);

}    // namespace anogate
