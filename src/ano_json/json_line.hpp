// JSON on one line that every program can read without loss.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include <string>

namespace ano {

/// Integers beyond 2^53 become text, because most programs read numbers as doubles. Bytes that are not UTF-8 (as in a path)
/// become U+FFFD.
std::string json_line(nlohmann::ordered_json json);

}    // namespace ano
