// Finds the default configuration file, which depends on where the program is installed.
#pragma once
#include <filesystem>
#include <string>

namespace anogate {

/// The configuration file that `program` reads by default: PREFIX/etc/anogate/anogate.json if it is PREFIX/bin/NAME and
/// PREFIX/etc/anogate exists; for /usr, /usr/local and all other places /etc/anogate/anogate.json. The installation uses the same
/// rule.
std::string config_file_of(const std::filesystem::path& program);

/// The same for the running program.
std::string default_config_file();

}    // namespace anogate
