// Reads the parameters of the gateway that a host saved.
#pragma once
#include <managed/managed_parameters.hpp>

#include <string>

namespace anogate {

/// The path of `what`.json in $STATE_DIRECTORY of the unit; else, in the user's folder for the state of programs, one for each
/// configuration file. Empty: there is no folder, or no configuration file.
std::string kept_state_path(const std::string& what, const std::string& config_file);

/// The path of parameters.json in $STATE_DIRECTORY of the unit; else, in the user's folder for the state of programs, one for
/// each configuration file. Empty: there is no folder, or no configuration file.
std::string kept_parameters_path(const std::string& config_file);

/// Reads the disk and may block. A file that can't be read is logged and ignored.
WrittenValues kept_parameters(const std::string& path);

}    // namespace anogate
