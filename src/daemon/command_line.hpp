// The command line of anogated, with the configuration that it names.
#pragma once
#include <gateway/settings.hpp>

#include <optional>
#include <string>

namespace anogate {

inline constexpr char default_config_file[] = "/etc/anogate/anogate.json";

/// There is nothing to run: `text` belongs on standard output when `status` is 0, else on standard error.
struct Exit {
    int status = 0;
    std::string text;
};

struct CommandLine {
    std::optional<Exit> exit;
    Settings settings;          // file, LINKs and options together, without fault; the control socket is never empty
    std::string config_file;    // that was read; empty: none
};

/// Reads the configuration file too: `default_file` when neither a file nor a link is named. Also does what --check,
/// --print-config, --help and --version ask for: then, and when anything is at fault, there is an exit.
CommandLine parse_command_line(int argc, const char* const* argv,
                               const std::string& default_file = default_config_file);

}  // namespace anogate
