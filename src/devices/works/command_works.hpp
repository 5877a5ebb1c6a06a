// Reads the commands of a device, and calls them.
#pragma once
#include <ano/values.hpp>
#include <devices/works/work.hpp>

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

/// `known`: returns them without a question if they were read before and the device was not away since.
std::unique_ptr<Work> read_commands(const WorkPlace& place, bool known);

struct CommandOrder {
    std::string command;                    // its name or number
    std::optional<std::string> called{};    // the name known to the client; if its number has another one now, it is not called
    bool repeat = false;                    // it may be repeated, and so carried out twice
    std::optional<ano::ValueType7> seven{};    // the meaning of value type 7 for the device, from now on
};
/// The list of commands is read only if the command is not known. `values`: a JSON array.
std::unique_ptr<Work> call_command(const WorkPlace& place, CommandOrder order, const nlohmann::ordered_json& values);

using Cid = std::array<std::uint8_t, 3>;
/// `values`: a JSON array of {TYPE: number}; numbers without a type are for a known command. Of `order` only `repeat` and `seven`
/// are used.
std::unique_ptr<Work> call_by_cid(const WorkPlace& place, const Cid& cid, CommandOrder order,
                                  const nlohmann::ordered_json& values);

}    // namespace anogate
