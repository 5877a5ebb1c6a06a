// Finds the default configuration file from the place where the program is installed.
#pragma once
#include <filesystem>
#include <string>

namespace anogate {

/// The configuration that `program` reads when nothing else is named: PREFIX/etc/anogate/anogate.json where it is PREFIX/bin/NAME
/// and PREFIX/etc/anogate exists; for /usr, /usr/local and anything else /etc/anogate/anogate.json. The installation uses the same rule.
std::string config_file_of(const std::filesystem::path& program);

/// The same for the running program.
std::string default_config_file();

}    // namespace anogate
