#include "programs.hpp"

#include <ano/address.hpp>
#include <ano/messages.hpp>
#include <ano_json/frame_json.hpp>
#include <anoctl/anoctl.hpp>
#include <config/link_kind.hpp>
#include <daemon/command_line.hpp>
#include <link/kinds.hpp>
#include <mavlink/command_line.hpp>
#include <mqtt/command_line.hpp>
#include <ros2/command_line.hpp>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <utility>
#include <variant>

namespace reference {
namespace {

constexpr char help_text[] = "Print this help and exit";

bool is_word(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::islower(c) != 0 || std::isdigit(c) != 0 || c == '-' || c == '_';
    });
}

}    // namespace

Offer Argument::offer() const {
    if (value == "[LINK...]" || (value.starts_with("LINK") && !names.empty())) return Offer::link_names;
    if (value.starts_with("LINK") || value.starts_with("KIND:")) return Offer::links;
    if (value.starts_with("FIELD=")) return Offer::fields;
    if (value.starts_with("DEVICE")) return Offer::devices;
    if (value.starts_with("[PARAMETER")) return Offer::parameters;
    if (value.starts_with("[COMMAND")) return Offer::commands;
    if (value.starts_with("ADDRESS")) return Offer::addresses;
    if (value.starts_with("PORT")) return Offer::ports;
    if (value.find("FILE") != value.npos || value.find("PATH") != value.npos || value == "DIR") return Offer::files;
    if (value == "ID..." || value == "NAME" || value == "[NAME...]") return Offer::messages;
    return words().empty() ? Offer::nothing : Offer::words;
}

std::vector<std::string> Argument::words() const {
    std::vector<std::string> all;
    if (value.find('|') == value.npos) return all;
    constexpr std::string_view more = "...";
    const std::string_view listed = std::string_view{value}.substr(0, value.size() - (is_repeated() ? more.size() : 0));
    for (const std::string_view word : anogate::split(listed, '|'))
        if (is_word(word)) all.emplace_back(word);
    return all;
}

Program anogated_program() {
    Command command{"", "Connect serial ports, CAN buses and UDP peers that use ANO V8 into one network", {}, {}};
    for (anogate::OptionText& option : anogate::option_texts("/etc/anogate/anogate.json")) {
        const bool is_help = std::find(option.names.begin(), option.names.end(), "--help") != option.names.end();
        Argument argument{option.names, option.value, is_help ? help_text : option.help};
        if (!argument.names.empty()) command.options.push_back(std::move(argument));
        else command.operands.push_back({{}, "LINK...", "Link to open: KIND:ADDRESS[,KEY=VALUE...]"});
    }
    return {"anogated", {command}};
}

Program anoctl_program() {
    Program program{"anoctl", {}};
    for (const anoctl::Subcommand& s : anoctl::subcommands()) {
        anoctl::Options options;
        s.add(options);
        Command command{s.name, s.description, {}, {}};
        for (const anoctl::Option& option : options) {
            if (option.name.starts_with("-")) command.options.push_back({{option.name}, option.value, option.help});
            else command.operands.push_back({{}, option.value, option.help});
        }
        command.options.push_back({{"-h", "--help"}, "", help_text});
        program.commands.push_back(std::move(command));
    }
    return program;
}

Program anogate_ros2_program() {
    Command command{"", "Publish the messages of a gateway's devices as ROS 2 topics", {}, {}};
    for (const anogate::Ros2Option& option : anogate::ros2_option_texts()) {
        const bool is_help = std::find(option.names.begin(), option.names.end(), "--help") != option.names.end();
        command.options.push_back({option.names, option.value, is_help ? help_text : option.help});
    }
    return {"anogate-ros2", {command}};
}

Program anogate_mavlink_program() {
    Command command{"", "Show the devices of a gateway to MAVLink ground stations", {}, {}};
    for (const anogate::MavlinkOption& option : anogate::mavlink_option_texts()) {
        const bool is_help = std::find(option.names.begin(), option.names.end(), "--help") != option.names.end();
        command.options.push_back({option.names, option.value, is_help ? help_text : option.help});
    }
    return {"anogate-mavlink", {command}};
}

Program anogate_mqtt_program() {
    Command command{"", "Publish the messages of a gateway's devices to an MQTT broker", {}, {}};
    for (const anogate::MqttOption& option : anogate::mqtt_option_texts()) {
        const bool is_help = std::find(option.names.begin(), option.names.end(), "--help") != option.names.end();
        command.options.push_back({option.names, option.value, is_help ? help_text : option.help});
    }
    return {"anogate-mqtt", {command}};
}

std::vector<std::string> message_names() {
    std::vector<std::string> names;
    for (const ano::Message& row : ano::messages) names.emplace_back(row.name);
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
}

// In lower case, with '_' instead of spaces; only names that belong to a single address.
std::vector<std::string> address_names() {
    std::vector<std::string> names;
    for (unsigned a = 1; a <= 255; ++a) {
        std::string name{ano::address::who(static_cast<std::uint8_t>(a))};
        for (char& c : name) c = c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        const auto called = ano::address_called(name);
        const auto* address = std::get_if<std::uint8_t>(&called);
        if (address && *address == a) names.push_back(std::move(name));
    }
    return names;
}

std::vector<std::string> link_prefixes() {
    std::vector<std::string> prefixes;
    for (const anogate::LinkKind* kind : anogate::link_kinds()) prefixes.push_back(std::string{kind->name} + ":");
    return prefixes;
}

}    // namespace reference
