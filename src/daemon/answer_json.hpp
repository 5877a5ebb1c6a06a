// How the daemon's answers write durations and text.
#pragma once
#include <ano/time.hpp>

#include <nlohmann/json.hpp>

#include <chrono>
#include <string>

namespace anogate {

/// Seconds, to the millisecond.
inline double in_seconds(ano::Duration d) {
    return static_cast<double>(std::chrono::duration_cast<std::chrono::milliseconds>(d).count()) / 1000;
}

/// A line. Names and errors may hold any byte (a path can): shown as U+FFFD where they are not UTF-8.
inline std::string line_of(const nlohmann::ordered_json& json) {
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}    // namespace anogate
