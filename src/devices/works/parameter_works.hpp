// Reads and writes parameters.
#pragma once
#include <devices/works/work.hpp>
#include <host/parameter_write.hpp>

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct ParameterOrder {
    bool values = true;                                 // with their values
    bool known = false;                                 // without values: as read before, if the device was not away since
    std::optional<std::vector<std::string>> words{};    // names or numbers of the wanted ones; at least one must be known
};
std::unique_ptr<Work> read_parameters(const WorkPlace& place, ParameterOrder order);
/// The parameter with this name or number.
std::unique_ptr<Work> read_parameter(const WorkPlace& place, std::string name);
/// The length of a text is limited as configured for the link.
std::unique_ptr<Work> write_parameter(const WorkPlace& place, std::string name, const nlohmann::ordered_json& value,
                                      ano::host::WriteLimits limits);

struct ApplyOrder {
    bool rollback = false;
    bool dry_run = false;
    bool longer = false;
    bool force = false;            // also values beyond the range that the device states
    bool goes_on = true;           // continues after one that the device refuses, unless `rollback`
    bool also_the_same = false;    // also writes those that do not differ
};
/// `values`: a JSON object of names and values.
std::unique_ptr<Work> apply_parameters(const WorkPlace& place, const nlohmann::ordered_json& values, ApplyOrder order);
/// save or restore_defaults.
std::unique_ptr<Work> act(const WorkPlace& place, ano::host::Action action, std::string name);

}    // namespace anogate
