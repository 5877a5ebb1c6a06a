#include <config/read_files.hpp>
#include <mavlink/command_line.hpp>
#include <mavlink/mavlink_config.hpp>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <system_error>
#include <utility>

namespace anogate {
namespace {

struct MavlinkArguments {
    std::string config;
    std::vector<std::pair<const Key<MavlinkSettings>*, std::string>> values;    // from options that set a key
    std::vector<std::string> udp, udp_listen, tcp_listen, serial, devices;
    bool check = false, print_config = false;
};

void add_mavlink_options(CLI::App& app, MavlinkArguments& arguments) {
    app.set_version_flag("-V,--version", "anogate-mavlink " ANOGATE_VERSION, "print the version");
    app.add_option("-c,--config", arguments.config,
                   std::string{"JSON file; options override its values (default: "} + mavlink_default_file + ", if it exists)")
        ->type_name("FILE");
    const auto list = [&app](const char* name, std::vector<std::string>& into, const char* value, const char* help) {
        app.add_option(name, into, std::string{help} + "; repeatable")->type_name(value)->allow_extra_args(false);
    };
    list("--udp", arguments.udp, "ADDR:PORT", "send to this ground station, such as 192.168.1.20:14550");
    list("--udp-listen", arguments.udp_listen, "ADDR:PORT", "ground stations send to this address first");
    list("--tcp-listen", arguments.tcp_listen, "ADDR:PORT", "ground stations connect to this address, such as 0.0.0.0:5760");
    list("--serial", arguments.serial, "DEVICE", "the serial port of a telemetry radio");
    list("--device", arguments.devices, "A:SYSID", "show the device with the hardware id A as this system (default: 0xDC:1)");
    for (const Key<MavlinkSettings>& key : mavlink_keys()) {
        if (key.option.empty()) continue;
        const auto keep = [&key, &arguments](const std::string& value) { arguments.values.emplace_back(&key, value); };
        app.add_option_function<std::string>(std::string{key.option}, keep, std::string{key.help})->type_name(placeholder(key));
    }
    app.add_flag("--check", arguments.check, "check the configuration: one error per line, exit status 0 or 78");
    app.add_flag("--print-config", arguments.print_config, "print the resulting configuration as a file");
}

std::string mavlink_error_lines(const ConfigErrors& errors) {
    std::string text;
    for (const ConfigError& error : errors) text += "anogate-mavlink: " + line_of(error) + '\n';
    return text;
}

// std::nullopt: the program runs.
std::optional<MavlinkExit> parse_mavlink_arguments(CLI::App& app, int argc, const char* const* argv) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        return MavlinkExit{0, app.help()};
    } catch (const CLI::CallForVersion& version) {
        return MavlinkExit{0, std::string{version.what()} + "\n"};
    } catch (const CLI::ParseError& error) {
        return MavlinkExit{exit_config, mavlink_error_lines({{"", error.what()}})};
    }
    return std::nullopt;
}

void read_mavlink_file(const std::string& given, const std::string& default_file, MavlinkCommandLine& line,
                       ConfigErrors& errors) {
    std::error_code ec;
    if (given.empty() && !std::filesystem::exists(default_file, ec)) return;
    line.config_file = given.empty() ? default_file : given;
    for (const ConfigText& file : read_config_file(line.config_file, errors))
        read_mavlink_config(file.text, file.file, line.settings, errors);
}

void use_mavlink_arguments(const MavlinkArguments& arguments, MavlinkSettings& settings, ConfigErrors& errors) {
    for (const auto& [key, value] : arguments.values)
        if (std::string wrong = key->set(value, settings); !wrong.empty())
            errors.push_back({std::string{key->option}, std::move(wrong)});
    if (!arguments.udp.empty()) settings.udp = arguments.udp;
    if (!arguments.udp_listen.empty()) settings.udp_listen = arguments.udp_listen;
    if (!arguments.tcp_listen.empty()) settings.tcp_listen = arguments.tcp_listen;
    if (!arguments.serial.empty()) settings.serial = arguments.serial;
    if (!arguments.devices.empty()) settings.devices.clear();
    for (const std::string& text : arguments.devices)
        if (const auto device = parse_mavlink_device(text)) settings.devices.push_back(*device);
        else errors.push_back({"--device", "must be a hardware id and a system id, such as 0xDC:1"});
    if (settings.devices.empty()) settings.devices.emplace_back();
}

}    // namespace

std::vector<MavlinkOption> mavlink_option_texts() {
    MavlinkArguments arguments;
    CLI::App app;
    add_mavlink_options(app, arguments);
    std::vector<MavlinkOption> texts;
    for (const CLI::Option* option : app.get_options()) {
        MavlinkOption text{{}, option->get_type_name(), option->get_description()};
        for (const std::string& name : option->get_snames()) text.names.push_back("-" + name);
        for (const std::string& name : option->get_lnames()) text.names.push_back("--" + name);
        texts.push_back(std::move(text));
    }
    return texts;
}

std::variant<MavlinkCommandLine, MavlinkExit> parse_mavlink_command_line(int argc, const char* const* argv,
                                                                         const std::string& default_file) {
    MavlinkArguments arguments;
    CLI::App app{"Shows the devices of a gateway to MAVLink ground stations, such as QGroundControl.", "anogate-mavlink"};
    add_mavlink_options(app, arguments);
    if (auto exit = parse_mavlink_arguments(app, argc, argv)) return *std::move(exit);
    MavlinkCommandLine line;
    ConfigErrors errors;
    line.check = arguments.check;
    line.print_config = arguments.print_config;
    read_mavlink_file(arguments.config, default_file, line, errors);
    use_mavlink_arguments(arguments, line.settings, errors);
    check_mavlink_settings(line.settings, errors);
    if (!errors.empty()) return MavlinkExit{exit_config, mavlink_error_lines(errors)};
    return line;
}

}    // namespace anogate
