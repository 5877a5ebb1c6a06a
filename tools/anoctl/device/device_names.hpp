// Finds devices by the names that they give themselves, and describes them.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// Those of `devices` (as in GET /devices) with this name; if there is none, compares without regard to case.
ano::Json with_name(const ano::Json& devices, const std::string& name);

/// "0xDC SimFC, 0xDD": for the user, who has to choose one.
std::string list_of(const ano::Json& devices);
bool all_have_names(const ano::Json& devices);

/// The error that no device has this name or address, with the list of devices.
std::string no_such_device(const std::string& name, const ano::Json& devices);
/// "SimFC (0xDC)", or "0xDC" while its name is not known.
std::string words_of_device(const ano::Json& device);
/// `words` that begin with the address of `device`, with its name inserted: "SimFC (0xDC) is unlocked…".
std::string with_device_named(std::string words, const ano::Json& device);

/// The traces of unfinished upgrades and calibrations, a clause each.
std::vector<std::string> left_behind(const ano::Json& device);

}    // namespace anoctl
