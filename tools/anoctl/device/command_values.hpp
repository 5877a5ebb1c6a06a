// The values of a command, as somebody typed them.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// The one of `commands` (as GET /devices/A/commands has them) that `word` stands for: its name, or its number. Throws UsageError for none, and for
/// several of that name.
const ano::Json& command_called(const ano::Json& commands, const std::string& word);

/// As the types of `command` want them. Throws UsageError: too few or too many, which one is no number, or beyond the range of its type.
ano::Json command_values(const ano::Json& command, const std::vector<std::string>& words);

/// "move u16 i16 f32"
std::string command_usage(const ano::Json& command);

}    // namespace anoctl
