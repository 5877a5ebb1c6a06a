// The command line of anogated, with the configuration files that it names.
#pragma once
#include <config/read_files.hpp>
#include <daemon/installed.hpp>
#include <gateway/settings.hpp>

#include <string>
#include <variant>
#include <vector>

namespace anogate {

struct CommandLine {
    Settings settings;                // file, LINKs and options together, checked
    std::string config_file;          // the file that was read; empty: none
    std::vector<ConfigText> files;    // config_file and those of conf.d, as they were read
    bool has_links = false;           // the command line contains links
    std::string warnings;             // one line per warning
    bool check = false;
    bool print_config = false;
};

/// The program must end: prints `text` to standard output if `code` is 0, else to standard error.
struct Exit {
    int code = 0;
    std::string text;
    ConfigErrors faults{};    // those listed in `text`
};

/// An option as --help shows it; an entry without names represents the LINK arguments.
struct OptionText {
    std::vector<std::string> names;    // "-c", "--config"
    std::string value;                 // "FILE"; empty: a flag
    std::string help;
};

/// All options, in the order of --help.
std::vector<OptionText> option_texts(const std::string& default_file);

/// Also reads the configuration files: `default_file` if the command line names neither a file nor a link. With `instead`, these
/// texts are used and no file is read.
std::variant<CommandLine, Exit> parse_command_line(int argc, const char* const* argv,
                                                   const std::string& default_file = default_config_file(),
                                                   const std::vector<ConfigText>* instead = nullptr);

}    // namespace anogate
