// Where the program was installed, which tells where its configuration is.
#pragma once
#include <filesystem>
#include <string>

namespace anogate {

/// The configuration that `program` reads when nothing else is named: PREFIX/etc/anogate/anogate.json where it is PREFIX/bin/NAME
/// and PREFIX/etc/anogate is there; for /usr, /usr/local and anything else /etc/anogate/anogate.json. As the installation does it.
std::string config_file_of(const std::filesystem::path& program);

/// The same for the program that runs.
std::string default_config_file();

}    // namespace anogate
