// JSON as one line, that every program reads without loss.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include <string>

namespace ano {

/// A line. Whole numbers beyond 2^53 become text, for most programs read a number as a double. Names and errors may hold any byte (a path
/// can): shown as U+FFFD where they are not UTF-8.
std::string json_line(nlohmann::ordered_json json);

}    // namespace ano
