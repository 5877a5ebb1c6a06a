// What a configuration of the service can't have, since systemd hides most of the file system from it: systemd/anogated.service.
#pragma once
#include <config/config.hpp>

#include <string>

namespace anogate {

/// Whether the configuration in `config_file` is the service's: it stands beside `default_file`, or we run as its user.
bool is_for_service(const std::string& config_file, const std::string& default_file);

/// Adds an error for every path that the service can't write to, and for every serial port that it can't see. The service is
/// anogated for anogate.json (or no file), anogated@NAME for NAME.json.
void check_for_service(Draft& draft, const std::string& config_file = {});

}    // namespace anogate
