// Parses the values of a command from the command line.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// The element of `commands` (as in GET /devices/A/commands) with the name or number `word`. Throws UsageError if there is none,
/// or if several have that name.
const ano::Json& command_called(const ano::Json& commands, const std::string& word);

/// The values in the types of `command`. `states_type_7`: the user states what value type 7 is, so `command` may show u64 for f32 and
/// f32 for u64; the gateway checks these values. Throws UsageError if their number is wrong, or if one is not a number or out of range.
ano::Json command_values(const ano::Json& command, const std::vector<std::string>& words, bool states_type_7 = false);

/// The body for POST …/commands/by-cid: `cid` is "16,0,5"; each word is "u16:150", or only a number. Throws UsageError.
ano::Json call_by_cid(const std::string& cid, const std::vector<std::string>& words);

/// "move u16 i16 f32"
std::string command_usage(const ano::Json& command);

}    // namespace anoctl
