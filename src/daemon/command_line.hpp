// The command line of anogated, with the configuration that it names.
#pragma once
#include <config/read_files.hpp>
#include <daemon/installed.hpp>
#include <gateway/settings.hpp>

#include <string>
#include <variant>
#include <vector>

namespace anogate {

struct CommandLine {
    Settings settings;                // file, LINKs and options together, without fault
    std::string config_file;          // that was read; empty: none
    std::vector<ConfigText> files;    // that one and the others of conf.d, as they were read
    bool has_links = false;           // the line itself names some
    std::string warnings;             // a line each
    bool check = false;
    bool print_config = false;
};

/// There is nothing to run: `text` belongs on standard output when `code` is 0, else on standard error.
struct Exit {
    int code = 0;
    std::string text;
    ConfigErrors faults{};    // of which `text` tells
};

/// An option as --help shows it; without names: the LINKs.
struct OptionText {
    std::vector<std::string> names;    // "-c", "--config"
    std::string value;                 // "FILE"; empty: a flag
    std::string help;
};

/// Every option that there is, in the order of --help.
std::vector<OptionText> option_texts(const std::string& default_file);

/// Reads the configuration file too. `default_file` is read when neither a file nor a link is named. `instead`, where it is given,
/// takes the place of what would be read.
std::variant<CommandLine, Exit> parse_command_line(int argc, const char* const* argv,
                                                   const std::string& default_file = default_config_file(),
                                                   const std::vector<ConfigText>* instead = nullptr);

}    // namespace anogate
