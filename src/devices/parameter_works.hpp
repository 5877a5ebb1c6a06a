// Reads and writes parameters.
#pragma once
#include <devices/work.hpp>
#include <host/parameter_write.hpp>

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string>
#include <vector>

namespace anogate {

/// All parameters, with or without their values.
std::unique_ptr<Work> read_parameters(const WorkPlace& place, bool values);
/// The parameters with these names and their values; unknown names are ignored.
std::unique_ptr<Work> read_parameters(const WorkPlace& place, std::vector<std::string> names);
/// The parameter with this name or number.
std::unique_ptr<Work> read_parameter(const WorkPlace& place, std::string name);
/// `longer`: a text may be longer than the one it replaces.
std::unique_ptr<Work> write_parameter(const WorkPlace& place, std::string name, const nlohmann::ordered_json& value, bool longer);

struct ApplyOrder {
    bool rollback = false;
    bool dry_run = false;
    bool longer = false;
};
/// `values`: a JSON object of names and values.
std::unique_ptr<Work> apply_parameters(const WorkPlace& place, const nlohmann::ordered_json& values, ApplyOrder order);
/// save or restore_defaults.
std::unique_ptr<Work> act(const WorkPlace& place, ano::host::Action action, std::string name);

}    // namespace anogate
