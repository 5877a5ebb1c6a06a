// The command lines of the programs as data, from the tables that --help also uses.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace reference {

/// The kind of values that a shell offers for an argument.
enum class Offer { nothing, words, files, messages, links, ports, addresses, link_names, fields, devices, parameters, commands };

struct Argument {
    std::vector<std::string> names;    // "-c", "--config"; empty: an operand
    std::string value;                 // "FILE"; empty: a flag
    std::string help;

    Offer offer() const;
    /// The words for Offer::words: "utf8", "gbk".
    std::vector<std::string> words() const;
    bool is_repeated() const { return value.ends_with("..."); }
};

struct Command {
    std::string name;    // empty: the program has no commands
    std::string help;
    std::vector<Argument> options;
    std::vector<Argument> operands;
};

struct Program {
    std::string name;
    std::vector<Command> commands;
};

Program anogated_program();
Program anoctl_program();
Program anogate_ros2_program();
Program anogate_mavlink_program();
Program anogate_mqtt_program();

std::vector<std::string> message_names();
/// The names that belong to a single address: "host", "flight_controller", …
std::vector<std::string> address_names();
/// "serial:", "udp-listen:", …
std::vector<std::string> link_prefixes();

}    // namespace reference
