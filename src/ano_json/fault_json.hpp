// A fault in the JSON of the control interface.
#pragma once
#include <ano/fault.hpp>

#include <nlohmann/json_fwd.hpp>

namespace ano {

/// Adds "error", the text, "error_id", "error_args", by their names, and "error_remarks" if it has further clauses. An argument or
/// a remark that is a clause with its own id is an object with these members, except "error".
void add_fault(nlohmann::ordered_json& json, const Fault& fault);

}    // namespace ano
