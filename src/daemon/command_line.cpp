#include <ano_json/nearest.hpp>
#include <config/check_network.hpp>
#include <config/config.hpp>
#include <config/help.hpp>
#include <config/hosts_file.hpp>
#include <config/keys.hpp>
#include <daemon/check_listener.hpp>
#include <daemon/check_paths.hpp>
#include <daemon/command_line.hpp>
#include <daemon/service.hpp>
#include <http/socket_path.hpp>
#include <link/kinds.hpp>
#include <link/udp/ip_socket.hpp>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

namespace anogate {
namespace {

constexpr char ad_hoc[] = "anogated serial:/dev/ttyUSB0,baud=500000,profile=vendor udp-listen:0.0.0.0:12333";

/// The content of the command line, before validation.
struct Arguments {
    std::vector<std::string> configs, links, routes;
    std::vector<std::pair<const KeyFacts*, std::string>> values;    // from options that set a key
    bool check = false, print_config = false;
};

/// Adds the options of all keys that have one; their values are stored in `arguments.values`.
template <class Section>
void add_options(CLI::App& app, Keys<Section> keys, Arguments& arguments) {
    for (const Key<Section>& key : keys) {
        if (key.option.empty()) continue;
        const auto keep = [&key, &arguments](const std::string& value) { arguments.values.emplace_back(&key, value); };
        app.add_option_function<std::string>(std::string{key.option}, keep, std::string{key.help})
            ->type_name(placeholder(key))
            ->take_last();
    }
}

void add_all(CLI::App& app, Arguments& arguments, const std::string& default_file) {
    app.set_version_flag("-V,--version", "anogated " ANOGATE_VERSION, "print the version");
    app.add_option("-c,--config", arguments.configs,
                   "JSON file; LINK arguments add to its links, options override its values (default: " + default_file +
                       ", if no LINK is given)")
        ->type_name("FILE")
        ->allow_extra_args(false);
    add_options(app, gateway_keys(), arguments);
    add_options(app, control_keys(), arguments);
    add_options(app, log_keys(), arguments);
    app.add_option("--route", arguments.routes, "pin an address or range (0xDC, 30-40) to a link, by name; repeatable")
        ->type_name("ADDR=LINK")
        ->allow_extra_args(false);
    app.add_flag("--check", arguments.check, "check the configuration: one error per line, exit status 0 or 78");
    app.add_flag("--print-config", arguments.print_config, "print the resulting configuration as a file");
    app.add_option("LINK", arguments.links, "links to connect, see below")->type_name(" ");
    app.footer(links_and_keys_help(link_kinds()));
    app.allow_extras();
}

std::vector<std::string> option_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return names;
}

/// A suggestion for an unknown option.
std::string meant_option(const std::string& name, const std::vector<std::string_view>& known) {
    const std::string bare = name.substr(std::min(name.find_first_not_of('-'), name.size()));
    if (const Key<LinkSettings>* key = find_key_of_any(link_kinds(), bare))
        return ": it is a key of a LINK: write KIND:ADDRESS," + bare + "=" + placeholder(*key);
    const std::string nearest = ano::did_you_mean(name, known);
    return nearest.empty() ? "; --help all lists all options" : nearest;
}

/// One error for each unknown option.
ConfigErrors reject_unknown_options(const CLI::App& app) {
    const auto names = option_names(app);
    const std::vector<std::string_view> known{names.begin(), names.end()};
    ConfigErrors errors;
    for (const std::string& option : app.remaining()) {
        const std::string name = option.substr(0, option.find('='));
        errors.push_back({"", "unknown option " + in_quotes(name) + meant_option(name, known)});
    }
    return errors;
}

/// One error for each option whose value is the next option.
ConfigErrors missing_values(const Arguments& arguments) {
    ConfigErrors errors;
    const auto look = [&](std::string_view option, const std::string& value) {
        if (value.starts_with("--")) errors.push_back({std::string{option}, "the value is missing before " + in_quotes(value)});
    };
    for (const std::string& file : arguments.configs) look("--config", file);
    for (const std::string& route : arguments.routes) look("--route", route);
    for (const auto& [key, value] : arguments.values) look(key->option, value);
    return errors;
}

Exit failure(const ConfigErrors& errors) { return {exit_config, lines(errors), errors}; }

/// std::nullopt: the program runs.
std::optional<Exit> parse(CLI::App& app, int argc, const char* const* argv, const std::string& default_file) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        const bool all = std::any_of(argv + 1, argv + argc, [](const char* word) { return std::string_view{word} == "all"; });
        return Exit{0, all ? app.help() : short_help(link_kinds(), default_file)};
    } catch (const CLI::CallForVersion& version) {
        return Exit{0, std::string{version.what()} + "\n"};
    } catch (const CLI::ParseError& error) {
        auto errors = reject_unknown_options(app);
        errors.push_back({"", error.what()});
        return failure(errors);
    }
    return std::nullopt;
}

template <class Section>
void set(const Key<Section>* key, const std::string& value, Section& section, ConfigErrors& errors) {
    if (key == nullptr) return;
    if (std::string wrong = key->set(value, section); !wrong.empty())
        errors.push_back({std::string{key->option}, std::move(wrong)});
}

template <class Section>
const Key<Section>* row_among(Keys<Section> keys, const KeyFacts* facts) {
    for (const Key<Section>& key : keys)
        if (&key == facts) return &key;
    return nullptr;
}

void read_options(const Arguments& arguments, Draft& draft) {
    for (const auto& [key, value] : arguments.values) {
        set(row_among(gateway_keys(), key), value, draft.settings.gateway, draft.errors);
        set(row_among(control_keys(), key), value, draft.settings.control, draft.errors);
        set(row_among(log_keys(), key), value, draft.settings.log, draft.errors);
        if (key->name == "unknown") draft.unknown = {std::string{key->option}};
        if (key->name == "socket") draft.control = {std::string{key->option}};
    }
}

std::vector<ConfigText> read_files(const std::string& path, bool by_default, Draft& draft) {
    ConfigErrors errors;
    std::vector<ConfigText> files = read_config_files(path, errors);
    if (by_default && files.empty()) errors.front().what += std::string{"; create it, or give links, for example: "} + ad_hoc;
    if (path.empty() && !errors.empty()) errors.front().where = "--config";
    draft.broken_links = !errors.empty();
    draft.errors.insert(draft.errors.end(), errors.begin(), errors.end());
    return files;
}

/// Whether a LINK argument is a configuration file instead.
bool is_config_file(const std::string& text) {
    std::error_code ec;
    const bool has_kind = find_link_kind(link_kinds(), text.substr(0, text.find(':'))) != nullptr;
    return !has_kind && (text.ends_with(".json") || std::filesystem::is_regular_file(text, ec));
}

void read_links(const std::vector<std::string>& links, Draft& draft) {
    for (const std::string& link : links) {
        if (!is_config_file(link)) {
            read_link(link, "", draft);
            continue;
        }
        draft.errors.push_back({"LINK " + in_quotes(link), "is not a link (did you mean --config " + printable(link) + "?)"});
        draft.broken_links = true;
    }
}

/// A configured path of the control socket must be usable, because clients connect to it.
void check_control(Draft& draft) {
    const std::string& socket = draft.settings.control.socket;
    if (socket.empty() || socket == "none") return;
    if (std::string fault = http::fault_of_socket(socket, http::this_runner()); !fault.empty())
        draft.errors.push_back({draft.control.key("socket"), std::move(fault)});
}

}    // namespace

std::vector<OptionText> option_texts(const std::string& default_file) {
    Arguments arguments;
    CLI::App app;
    add_all(app, arguments, default_file);
    std::vector<OptionText> texts;
    for (const CLI::Option* option : app.get_options()) {
        OptionText text{{}, option->get_type_name(), option->get_description()};
        for (const std::string& name : option->get_snames()) text.names.push_back("-" + name);
        for (const std::string& name : option->get_lnames()) text.names.push_back("--" + name);
        texts.push_back(std::move(text));
    }
    return texts;
}

std::variant<CommandLine, Exit> parse_command_line(int argc, const char* const* argv, const std::string& default_file,
                                                   const std::vector<ConfigText>* instead) {
    Arguments arguments;
    CLI::App app{"Connects serial ports, CAN buses and network peers that use ANO V8.", "anogated"};
    add_all(app, arguments, default_file);
    if (auto exit = parse(app, argc, argv, default_file)) return *std::move(exit);
    if (const ConfigErrors missing = missing_values(arguments); !missing.empty()) return failure(missing);

    Draft draft{link_kinds()};
    draft.errors = reject_unknown_options(app);
    if (arguments.configs.size() > 1)
        draft.errors.push_back(
            {"--config", "was given " + std::to_string(arguments.configs.size()) + " times; only one file is allowed"});
    const bool by_default = arguments.configs.empty() && arguments.links.empty();
    const std::string file = by_default ? default_file : arguments.configs.empty() ? "" : arguments.configs.front();
    std::vector<ConfigText> files;
    if (instead) files = *instead;
    else if (by_default ? draft.errors.empty() : !arguments.configs.empty()) files = read_files(file, by_default, draft);
    read_config(files, draft);
    read_links(arguments.links, draft);
    for (const std::string& route : arguments.routes) read_route(route, "--route '" + route + "'", draft);
    read_options(arguments, draft);
    validate(draft);
    const bool for_service = arguments.check && is_for_service(file, default_file);
    if (for_service) check_for_service(draft, file);
    else if (!arguments.print_config) check_control(draft);
    if (arguments.check) {
        warn_of_paths(draft);
        warn_of_listener(draft, for_service);
        const std::vector<Network> own = own_networks();
        check_peers(draft, read_hosts_file("/etc/hosts"), own);
        check_relay(draft, own);
        note_open_ports(draft);
    }
    if (!draft.errors.empty()) return failure(draft.errors);
    return CommandLine{
        std::move(draft.settings), file, std::move(files), !arguments.links.empty(), lines(draft.warnings), arguments.check,
        arguments.print_config};
}

}    // namespace anogate
