// Parses JSON and refuses what nlohmann-json accepts: keys given twice, unlimited nesting.
#pragma once
#include <config/config_error.hpp>

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// Comments are allowed. Errors name `file` and the line, or the JSON pointer. std::nullopt when it is not JSON; of a
/// key given twice the last value is returned, so that the rest can be checked as well.
std::optional<nlohmann::json> parse_json(std::string_view text, const std::string& file, ConfigErrors& errors);

/// "FILE: /links/0": what stands before an error at `pointer`.
std::string at(const std::string& file, const std::string& pointer);

}    // namespace anogate
