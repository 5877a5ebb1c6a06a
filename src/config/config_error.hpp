// What is wrong in a configuration, and where.
#pragma once
#include <string>
#include <vector>

namespace anogate {

inline constexpr int exit_config = 78;    // EX_CONFIG: systemd and scripts know it

struct ConfigError {
    std::string where;    // "FILE: /links/0/baud", "LINK 'serial:/dev/x'", "--id"
    std::string what;
};
using ConfigErrors = std::vector<ConfigError>;

/// "WHERE: WHAT", in one line whatever bytes were given.
std::string line_of(const ConfigError& error);
/// "anogated: WHERE: WHAT", a line each.
std::string lines(const ConfigErrors& errors);

/// `text` on one line: control characters and bytes that are not UTF-8 become \xNN; text longer than `max_bytes` is cut.
std::string printable(const std::string& text, std::size_t max_bytes = 200);

}    // namespace anogate
