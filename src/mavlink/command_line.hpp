// The command line of anogate-mavlink, with its configuration file.
#pragma once
#include <mavlink/settings.hpp>

#include <string>
#include <variant>
#include <vector>

namespace anogate {

struct MavlinkCommandLine {
    MavlinkSettings settings;
    std::string config_file;    // the file that was read; empty: none
    bool check = false;
    bool print_config = false;
};

/// The program must end: prints `text` to standard output if `code` is 0, else to standard error.
struct MavlinkExit {
    int code = 0;
    std::string text;
};

/// An option as --help shows it.
struct MavlinkOption {
    std::vector<std::string> names;    // "-c", "--config"
    std::string value;                 // "FILE"; empty: a flag
    std::string help;
};
std::vector<MavlinkOption> mavlink_option_texts();

inline constexpr char mavlink_default_file[] = "/etc/anogate/mavlink.json";

/// `default_file` is read if it exists and the command line names no other.
std::variant<MavlinkCommandLine, MavlinkExit> parse_mavlink_command_line(int argc, const char* const* argv,
                                                                         const std::string& default_file = mavlink_default_file);

}    // namespace anogate
