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
    Settings settings;                // file, LINKs and options together, checked
    std::string config_file;          // the file that was read; empty: none
    std::vector<ConfigText> files;    // config_file and those of conf.d, as they were read
    bool has_links = false;           // the command line itself names links
    std::string warnings;             // one line for each warning
    bool check = false;
    bool print_config = false;
};

/// The program is to end: `text` goes to standard output when `code` is 0, else to standard error.
struct Exit {
    int code = 0;
    std::string text;
    ConfigErrors faults{};    // the ones that `text` lists
};

/// An option as --help shows it; an entry without names stands for the LINK arguments.
struct OptionText {
    std::vector<std::string> names;    // "-c", "--config"
    std::string value;                 // "FILE"; empty: a flag
    std::string help;
};

/// Every option that there is, in the order of --help.
std::vector<OptionText> option_texts(const std::string& default_file);

/// Reads the configuration files too: `default_file` when the command line names neither a file nor a link. With `instead`, these texts
/// are used and nothing is read from the disk.
std::variant<CommandLine, Exit> parse_command_line(int argc, const char* const* argv,
                                                   const std::string& default_file = default_config_file(),
                                                   const std::vector<ConfigText>* instead = nullptr);

}    // namespace anogate
