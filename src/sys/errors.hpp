// Texts for errno.
#pragma once
#include <cerrno>
#include <string>
#include <system_error>

namespace anogate {

/// The text of an errno value: "Permission denied".
inline std::string error_text(int error) { return std::generic_category().message(error); }

/// "/dev/ttyUSB0: No such file or directory"
inline std::string error_text(const std::string& what, int error) { return what + ": " + error_text(error); }

}    // namespace anogate
