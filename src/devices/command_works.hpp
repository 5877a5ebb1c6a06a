// Works that ask for the commands of a device, and call them.
#pragma once
#include <devices/work.hpp>

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string>

namespace anogate {

std::unique_ptr<Work> read_commands(const WorkPlace& place);
/// The one that is called so, or has this number. `values`: a JSON array; `repeat`: it may be carried out twice.
std::unique_ptr<Work> call_command(const WorkPlace& place, std::string name, const nlohmann::ordered_json& values, bool repeat);

}    // namespace anogate
