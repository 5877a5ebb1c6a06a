// Parses JSON. Refuses duplicate keys and unlimited nesting, which nlohmann-json accepts.
#pragma once
#include <config/config_error.hpp>

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// Comments are allowed. Errors contain `file` and the line, or the JSON pointer. std::nullopt: not JSON. For a duplicate key the
/// last value is returned, so that the rest can be checked as well.
std::optional<nlohmann::json> parse_json(std::string_view text, const std::string& file, ConfigErrors& errors);

/// "FILE: /links/0": the place of an error at `pointer`.
std::string at(const std::string& file, const std::string& pointer);

}    // namespace anogate
