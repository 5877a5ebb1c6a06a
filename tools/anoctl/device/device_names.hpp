// Finds devices by their names, and describes them.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// The elements of `devices` (as in GET /devices) with this name; if there are none, those with this name in another case.
ano::Json with_name(const ano::Json& devices, const std::string& name);

/// "0xDC SimFC, 0xDD": the choices, for an error message.
std::string list_of(const ano::Json& devices);
bool all_have_names(const ano::Json& devices);

/// The error that no device has this name or address, with the list of devices.
std::string no_such_device(const std::string& name, const ano::Json& devices);
/// "SimFC (0xDC)", or "0xDC" if its name is not known.
std::string format_device(const ano::Json& device);
/// Inserts the name of `device` in `words` that begin with its address: "SimFC (0xDC) is unlocked…".
std::string with_device_named(std::string words, const ano::Json& device);

/// One clause for each unfinished upgrade or calibration of the device.
std::vector<std::string> left_behind(const ano::Json& device);

}    // namespace anoctl
