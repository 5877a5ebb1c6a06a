// Errors of a configuration, with their place.
#pragma once
#include <string>
#include <vector>

namespace anogate {

inline constexpr int exit_config = 78;    // EX_CONFIG, known to systemd and scripts

struct ConfigError {
    std::string where;    // "FILE: /links/0/baud", "LINK 'serial:/dev/x'", "--id"
    std::string what;
};
using ConfigErrors = std::vector<ConfigError>;

/// "WHERE: WHAT", on one line for any bytes.
std::string line_of(const ConfigError& error);
/// "anogated: WHERE: WHAT", one line per error.
std::string lines(const ConfigErrors& errors);

/// `text` on one line: control characters and bytes that are not UTF-8 are escaped as \xNN; text longer than `max_bytes` is
/// truncated.
std::string printable(const std::string& text, std::size_t max_bytes = 200);

}    // namespace anogate
