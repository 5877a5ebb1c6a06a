// Reads the commands of a device, and calls them.
#pragma once
#include <devices/work.hpp>

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string>

namespace anogate {

std::unique_ptr<Work> read_commands(const WorkPlace& place);
/// `name`: the name or the number of the command; `values`: a JSON array; `repeat`: it may be repeated, and so carried out twice.
std::unique_ptr<Work> call_command(const WorkPlace& place, std::string name, const nlohmann::ordered_json& values, bool repeat);

}    // namespace anogate
