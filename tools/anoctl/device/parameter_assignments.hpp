// NAME=VALUE, as somebody typed them, and the parameters of a device.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace anoctl {

struct Assignment {
    std::string name, value;
};

/// NAME VALUE, or NAME=VALUE... Throws UsageError.
std::vector<Assignment> assignments(const std::vector<std::string>& words);

/// The one of `parameters` (as GET /devices/A/parameters has them) that `word` stands for: its name, else its number. Throws Failure for
/// none, with the name that is near, and for several of that name.
const ano::Json& parameter_called(const ano::Json& parameters, const std::string& word);

/// Whether every one is there, once, and its value of its type. Throws Failure with the first that is not.
void check(const std::vector<Assignment>& wanted, const ano::Json& parameters);

}    // namespace anoctl
