// The command line of anogate-ros2, with its configuration file.
#pragma once
#include <ros2/settings.hpp>

#include <string>
#include <variant>
#include <vector>

namespace anogate {

struct Ros2CommandLine {
    Ros2Settings settings;
    std::string config_file;    // the file that was read; empty: none
    bool list = false;
    bool check = false;
    bool print_config = false;
};

/// The program must end: prints `text` to standard output if `code` is 0, else to standard error.
struct Ros2Exit {
    int code = 0;
    std::string text;
};

/// An option as --help shows it.
struct Ros2Option {
    std::vector<std::string> names;    // "-c", "--config"
    std::string value;                 // "FILE"; empty: a flag
    std::string help;
};
std::vector<Ros2Option> ros2_option_texts();

inline constexpr char ros2_default_file[] = "/etc/anogate/ros2.json";

/// `default_file` is read if it exists and the command line names no other.
std::variant<Ros2CommandLine, Ros2Exit> parse_ros2_command_line(int argc, const char* const* argv,
                                                                const std::string& default_file = ros2_default_file);

}    // namespace anogate
