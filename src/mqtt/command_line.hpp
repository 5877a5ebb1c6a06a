// The command line of anogate-mqtt, with its configuration file.
#pragma once
#include <mqtt/settings.hpp>

#include <string>
#include <variant>
#include <vector>

namespace anogate {

struct MqttCommandLine {
    MqttSettings settings;
    std::string config_file;    // the file that was read; empty: none
    bool collect = false, mcap = false;
    std::string to;    // the folder of --collect
    bool check = false, print_config = false, print_acl = false;
};

/// The program must end: prints `text` to standard output if `code` is 0, else to standard error.
struct MqttExit {
    int code = 0;
    std::string text;
};

/// An option as --help shows it.
struct MqttOption {
    std::vector<std::string> names;    // "-c", "--config"
    std::string value;                 // "FILE"; empty: a flag
    std::string help;
};
std::vector<MqttOption> mqtt_option_texts();

inline constexpr char mqtt_default_file[] = "/etc/anogate/mqtt.json";

/// `default_file` is read if it exists and the command line names no other.
std::variant<MqttCommandLine, MqttExit> parse_mqtt_command_line(int argc, const char* const* argv,
                                                                const std::string& default_file = mqtt_default_file);

}    // namespace anogate
