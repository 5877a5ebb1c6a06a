#include <config/read_files.hpp>
#include <mqtt/command_line.hpp>
#include <mqtt/mqtt_config.hpp>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

namespace anogate {
namespace {

struct MqttArguments {
    std::string config;
    std::vector<std::pair<const Key<MqttSettings>*, std::string>> values;    // from options that set a key
    MqttCommandLine line;
};

void add_mqtt_options(CLI::App& app, MqttArguments& arguments) {
    MqttCommandLine& line = arguments.line;
    app.set_version_flag("-V,--version", "anogate-mqtt " ANOGATE_VERSION, "print the version");
    app.add_option("-c,--config", arguments.config,
                   std::string{"JSON file; options override its values (default: "} + mqtt_default_file + ", if it exists)")
        ->type_name("FILE");
    for (const Key<MqttSettings>& key : mqtt_keys()) {
        if (key.option.empty()) continue;
        const auto keep = [&key, &arguments](const std::string& value) { arguments.values.emplace_back(&key, value); };
        app.add_option_function<std::string>(std::string{key.option}, keep, std::string{key.help})->type_name(placeholder(key));
    }
    auto* collect = app.add_flag("--collect", line.collect,
                                 "receive the records of all gateways and write each once, as lines of JSON in "
                                 "FOLDER/GATEWAY/DATE.ndjson");
    app.add_option("--to", line.to, "the folder of --collect")->type_name("FOLDER")->needs(collect);
    app.add_flag("--mcap", line.mcap, "with --collect, also write FOLDER/GATEWAY/TIME.mcap, for Foxglove and anoctl")
        ->needs(collect);
    app.add_flag("--check", line.check, "check the configuration: one error per line, exit status 0 or 78");
    app.add_flag("--print-config", line.print_config, "print the resulting configuration as a file");
    app.add_flag("--print-acl", line.print_acl, "print access rules of a whole fleet for mosquitto");
}

std::string error_lines(const ConfigErrors& errors) {
    std::string text;
    for (const ConfigError& error : errors) text += "anogate-mqtt: " + line_of(error) + '\n';
    return text;
}

// std::nullopt: the program runs.
std::optional<MqttExit> parse_arguments(CLI::App& app, int argc, const char* const* argv) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        return MqttExit{0, app.help()};
    } catch (const CLI::CallForVersion& version) {
        return MqttExit{0, std::string{version.what()} + "\n"};
    } catch (const CLI::ParseError& error) {
        return MqttExit{exit_config, error_lines({{"", error.what()}})};
    }
    return std::nullopt;
}

void read_mqtt_file(const std::string& given, const std::string& default_file, MqttCommandLine& line, ConfigErrors& errors) {
    std::error_code ec;
    if (given.empty() && !std::filesystem::exists(default_file, ec)) return;
    line.config_file = given.empty() ? default_file : given;
    for (const ConfigText& file : read_config_file(line.config_file, errors))
        read_mqtt_config(file.text, file.file, line.settings, errors);
}

}    // namespace

std::vector<MqttOption> mqtt_option_texts() {
    MqttArguments arguments;
    CLI::App app;
    add_mqtt_options(app, arguments);
    std::vector<MqttOption> texts;
    for (const CLI::Option* option : app.get_options()) {
        MqttOption text{{}, option->get_type_name(), option->get_description()};
        for (const std::string& name : option->get_snames()) text.names.push_back("-" + name);
        for (const std::string& name : option->get_lnames()) text.names.push_back("--" + name);
        texts.push_back(std::move(text));
    }
    return texts;
}

std::variant<MqttCommandLine, MqttExit> parse_mqtt_command_line(int argc, const char* const* argv,
                                                                const std::string& default_file) {
    MqttArguments arguments;
    CLI::App app{"Publishes the messages of a gateway's devices to an MQTT 5 broker, and stores them while it can't be reached.",
                 "anogate-mqtt"};
    add_mqtt_options(app, arguments);
    if (auto exit = parse_arguments(app, argc, argv)) return *std::move(exit);
    MqttCommandLine& line = arguments.line;
    ConfigErrors errors;
    read_mqtt_file(arguments.config, default_file, line, errors);
    for (const auto& [key, value] : arguments.values)
        if (std::string wrong = key->set(value, line.settings); !wrong.empty())
            errors.push_back({std::string{key->option}, std::move(wrong)});
    if (!line.print_acl) check_mqtt_settings(line.settings, errors);
    if (line.collect && line.to.empty()) errors.push_back({"--collect", "needs a folder: --to FOLDER"});
    if (!errors.empty()) return MqttExit{exit_config, error_lines(errors)};
    return line;
}

}    // namespace anogate
