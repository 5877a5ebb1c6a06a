// How the daemon's answers write durations and text.
#pragma once
#include <ano/time.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace anogate {

/// Seconds, to the millisecond.
double in_seconds(ano::Duration d);

/// A line. Whole numbers beyond 2^53 become text, for most programs read a number as a double. Names and errors may hold any byte (a path can): shown as U+FFFD where they are not UTF-8.
std::string line_of(nlohmann::ordered_json json);

}    // namespace anogate
