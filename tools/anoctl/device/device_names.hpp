// Devices by what they call themselves, and what is to be said of one.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// Those of `devices` (as GET /devices has them) that are called `name`; where none is, those that are but for upper and lower case.
ano::Json with_name(const ano::Json& devices, const std::string& name);

/// "0xDC SimFC, 0xDD": for who has to choose one.
std::string list_of(const ano::Json& devices);
bool all_have_names(const ano::Json& devices);

/// Why there is none of that name or address, and who is there.
std::string no_such_device(const std::string& name, const ano::Json& devices);
/// "SimFC (0xDC)", or "0xDC" while its name is not known.
std::string words_of_device(const ano::Json& device);
/// What begins with the address of `device`, with its name: "SimFC (0xDC) is unlocked…".
std::string with_device_named(std::string words, const ano::Json& device);

/// What an upgrade or a calibration that did not end left behind, a clause each.
std::vector<std::string> left_behind(const ano::Json& device);

}    // namespace anoctl
