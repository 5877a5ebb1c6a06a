// Finds settings that can't work in the service, because systemd hides most of the file system from it: systemd/anogated.service.
#pragma once
#include <config/config.hpp>

#include <string>

namespace anogate {

/// Whether `config_file` is for the service: it is in the folder of `default_file`, or this process runs as the user of the
/// service.
bool is_for_service(const std::string& config_file, const std::string& default_file);

/// Adds an error for every path that the service can't write to, and for every serial port that is not visible to it. The service
/// is anogated for anogate.json (or no file), anogated@NAME for NAME.json.
void check_for_service(Draft& draft, const std::string& config_file = {});

}    // namespace anogate
