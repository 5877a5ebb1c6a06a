#include <ano_json/nearest.hpp>
#include <config/read_files.hpp>
#include <ros2/command_line.hpp>
#include <ros2/ros2_config.hpp>

#include <CLI/CLI.hpp>

#include <filesystem>
#include <system_error>
#include <utility>

namespace anogate {
namespace {

struct Ros2Arguments {
    std::string config;
    std::vector<std::pair<const Key<Ros2Settings>*, std::string>> values;    // from options that set a key
    std::vector<std::string> interfaces;
    bool list = false, check = false, print_config = false;
};

void add_ros2_options(CLI::App& app, Ros2Arguments& arguments) {
    app.set_version_flag("-V,--version", "anogate-ros2 " ANOGATE_VERSION, "print the version");
    app.add_option("-c,--config", arguments.config,
                   std::string{"JSON file; options override its values (default: "} + ros2_default_file + ", if it exists)")
        ->type_name("FILE");
    for (const Key<Ros2Settings>& key : ros2_keys()) {
        if (key.option.empty()) continue;
        const auto keep = [&key, &arguments](const std::string& value) { arguments.values.emplace_back(&key, value); };
        app.add_option_function<std::string>(std::string{key.option}, keep, std::string{key.help})->type_name(placeholder(key));
    }
    app.add_option("--interface", arguments.interfaces, "use only this network interface; repeatable (default: all)")
        ->type_name("INTERFACE")
        ->allow_extra_args(false);
    app.add_flag("--list", arguments.list,
                 "receive frames for 3 s; print each topic, its source, its rate, and why it is silent");
    app.add_flag("--check", arguments.check, "check the configuration: one error per line, exit status 0 or 78");
    app.add_flag("--print-config", arguments.print_config, "print the resulting configuration as a file");
}

std::string error_lines(const ConfigErrors& errors) {
    std::string text;
    for (const ConfigError& error : errors) text += "anogate-ros2: " + line_of(error) + '\n';
    return text;
}

// std::nullopt: the program runs.
std::optional<Ros2Exit> parse_arguments(CLI::App& app, int argc, const char* const* argv) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        return Ros2Exit{0, app.help()};
    } catch (const CLI::CallForVersion& version) {
        return Ros2Exit{0, std::string{version.what()} + "\n"};
    } catch (const CLI::ParseError& error) {
        return Ros2Exit{exit_config, error_lines({{"", error.what()}})};
    }
    return std::nullopt;
}

void read_ros2_file(const std::string& given, const std::string& default_file, Ros2CommandLine& line, ConfigErrors& errors) {
    std::error_code ec;
    if (given.empty() && !std::filesystem::exists(default_file, ec)) return;
    line.config_file = given.empty() ? default_file : given;
    for (const ConfigText& file : read_config_file(line.config_file, errors))
        read_ros2_config(file.text, file.file, line.settings, errors);
}

}    // namespace

std::vector<Ros2Option> ros2_option_texts() {
    Ros2Arguments arguments;
    CLI::App app;
    add_ros2_options(app, arguments);
    std::vector<Ros2Option> texts;
    for (const CLI::Option* option : app.get_options()) {
        Ros2Option text{{}, option->get_type_name(), option->get_description()};
        for (const std::string& name : option->get_snames()) text.names.push_back("-" + name);
        for (const std::string& name : option->get_lnames()) text.names.push_back("--" + name);
        texts.push_back(std::move(text));
    }
    return texts;
}

std::variant<Ros2CommandLine, Ros2Exit> parse_ros2_command_line(int argc, const char* const* argv,
                                                                const std::string& default_file) {
    Ros2Arguments arguments;
    CLI::App app{"Publishes the messages of a gateway's devices as ROS 2 topics. ROS is not needed.", "anogate-ros2"};
    add_ros2_options(app, arguments);
    if (auto exit = parse_arguments(app, argc, argv)) return *std::move(exit);
    Ros2CommandLine line;
    ConfigErrors errors;
    line.list = arguments.list;
    line.check = arguments.check;
    line.print_config = arguments.print_config;
    read_ros2_file(arguments.config, default_file, line, errors);
    for (const auto& [key, value] : arguments.values)
        if (std::string wrong = key->set(value, line.settings); !wrong.empty())
            errors.push_back({std::string{key->option}, std::move(wrong)});
    if (!arguments.interfaces.empty()) line.settings.interfaces = arguments.interfaces;
    if (!errors.empty()) return Ros2Exit{exit_config, error_lines(errors)};
    return line;
}

}    // namespace anogate
