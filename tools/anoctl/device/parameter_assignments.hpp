// Parses NAME=VALUE from the command line, and checks them against the parameters of a device.
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

/// The element of `parameters` (as in GET /devices/A/parameters) with `word` as its name, else as its number. Throws Failure if
/// there is none (with the most similar name), or if several have that name.
const ano::Json& parameter_called(const ano::Json& parameters, const std::string& word);

/// Checks that every parameter exists, occurs once, and has a value of its type. Throws Failure for the first one that does not.
void check(const std::vector<Assignment>& wanted, const ano::Json& parameters);

}    // namespace anoctl
