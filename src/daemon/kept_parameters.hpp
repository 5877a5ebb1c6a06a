// The parameters of the gateway that a host saved, for the next start.
#pragma once
#include <managed/managed_parameters.hpp>

#include <string>

namespace anogate {

/// parameters.json in $STATE_DIRECTORY of the unit; else, in the user's folder for the state of programs, one for each configuration
/// file. Empty: there is no folder, or no file.
std::string kept_parameters_path(const std::string& config_file);

/// Reads a disk, and may block. What can't be read is told in the log, and is not there.
WrittenValues kept_parameters(const std::string& path);

}    // namespace anogate
