// Works that read and write parameters.
#pragma once
#include <devices/work.hpp>
#include <host/parameter_write.hpp>

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string>
#include <vector>

namespace anogate {

/// All of them; with their values or without.
std::unique_ptr<Work> read_parameters(const WorkPlace& place, bool values);
/// Those of these names, with their values; names that none is called by are passed over.
std::unique_ptr<Work> read_parameters(const WorkPlace& place, std::vector<std::string> names);
/// The one that is called so, or has this number.
std::unique_ptr<Work> read_parameter(const WorkPlace& place, std::string name);
/// `value` is JSON; `longer`: a text may be longer than the one that it replaces.
std::unique_ptr<Work> write_parameter(const WorkPlace& place, std::string name, const nlohmann::ordered_json& value, bool longer);

struct ApplyOrder {
    bool rollback = false;
    bool dry_run = false;
    bool longer = false;
};
/// `values`: names and values, a JSON object.
std::unique_ptr<Work> apply_parameters(const WorkPlace& place, const nlohmann::ordered_json& values, ApplyOrder order);
/// save or restore_defaults.
std::unique_ptr<Work> act(const WorkPlace& place, ano::host::Action action, std::string name);

}    // namespace anogate
