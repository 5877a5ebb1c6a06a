// Text to JSON, with what nlohmann-json lets pass refused: keys given twice, nesting without end.
#pragma once
#include <config/config_error.hpp>

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// Comments are allowed. Errors name `file` and the line, or the pointer. Nothing when it is no JSON; of a key given
/// twice the last counts, for what else there is to say.
std::optional<nlohmann::json> parse_json(std::string_view text, const std::string& file, ConfigErrors& errors);

/// "FILE: /links/0": what stands before an error at `pointer`.
std::string at(const std::string& file, const std::string& pointer);

}    // namespace anogate
