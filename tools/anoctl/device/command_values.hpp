// Parses the values of a command from the command line.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// The one of `commands` (as in GET /devices/A/commands) named or numbered `word`. Throws UsageError when there is none, or several
/// have that name.
const ano::Json& command_called(const ano::Json& commands, const std::string& word);

/// The values in the types of `command`. Throws UsageError when there are too few or too many, or one is no number or out of range.
ano::Json command_values(const ano::Json& command, const std::vector<std::string>& words);

/// The body for POST …/commands/by-cid: `cid` is "16,0,5", each word "u16:150", or a number alone. Throws UsageError.
ano::Json call_by_cid(const std::string& cid, const std::vector<std::string>& words);

/// "move u16 i16 f32"
std::string command_usage(const ano::Json& command);

}    // namespace anoctl
