#include "anoctl.hpp"

#include "complete.hpp"
#include "say.hpp"

#include <ano_json/frame_json.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <exception>
#include <map>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {

std::span<const Subcommand> subcommands() noexcept {
    static constexpr std::array<Subcommand, 32> all{{
        {"decode", "Decode the frames in bytes", add_decode, "Frames",
         "  anoctl decode AB DC FE 03 07 00 7B 00 00 00 00 00 01 09 E4\n  anoctl decode --json < bytes.txt\n"},
        {"encode", "Encode a frame", add_encode, "Frames", "  anoctl encode euler rol=1.5 pit=0\n"},
        {"messages", "Show the messages of the protocol", add_messages, "Frames", ""},
        {"monitor", "Show the frames of the running gateway, or of a link", add_monitor, "Watching",
         "  anoctl monitor --id euler inertial\n  anoctl monitor --direction dropped          dropped frames, and why\n  anoctl "
         "monitor serial:/dev/ttyUSB0,baud=500000     without a gateway\n"},
        {"ports",
         "Show serial ports, HID devices and CAN interfaces, and the programs that use them; detect the baud rate of a device",
         add_ports, "Gateway", "  anoctl ports\n"},
        {"setup", "Set up the service: port, baud rate, configuration, start, page; ask before each step", add_setup, "Gateway",
         "  sudo anoctl setup\n  sudo anoctl setup /dev/ttyUSB0 --yes\n"},
        {"status", "Show the status of a running gateway", add_status, "Gateway",
         "  anoctl status\n  anoctl status --exit-code > /dev/null || echo \"degraded\"\n"},
        {"links", "Show the links of the gateway and their counters", add_links, "Gateway", ""},
        {"routes", "Show the route of each address", add_routes, "Gateway", ""},
        {"metrics", "Show the counters of the gateway in the Prometheus text format", add_metrics, "Gateway", ""},
        {"reload", "Reload the configuration of the gateway", add_reload, "Gateway", ""},
        {"flexible", "Show or set the layouts of flexible messages", add_flexible, "Gateway", ""},
        {"send", "Send a frame through the running gateway", add_send, "Frames", "  anoctl send euler rol=1 --to 0xDC\n"},
        {"devices", "List devices", add_devices, "Devices", "  anoctl devices --scan\n"},
        {"param", "Read and write the parameters of a device; export, import and compare parameter files", add_param, "Devices",
         "  anoctl param list --device 0xDC\n  anoctl param set PID_P 4.5 && anoctl param save\n  anoctl param export "
         "backup.json\n  anoctl param diff backup.json\n"},
        {"command", "List and call the commands of a device", add_command, "Devices",
         "  anoctl command list\n  anoctl command call TAKE_OFF 150\n"},
        {"waypoint", "Read the waypoints of a device into a file, or write them back", add_waypoint, "Devices", ""},
        {"flash", "Update the firmware of a device", add_flash, "Devices", "  anoctl flash firmware.bin --device 0xDC\n"},
        {"calibrate", "Calibrate the accelerometer or the compass of a device", add_calibrate, "Devices",
         "  anoctl calibrate accelerometer --device 0xDC\n"},
        {"log", "Show the log messages of devices, in color", add_log, "Watching", ""},
        {"alarms", "Show which values of devices exceed their limits", add_alarms, "Watching",
         "  anoctl alarms\n  anoctl alarms --follow --device 0xDC\n"},
        {"image", "Save the images that devices send as PNG files", add_image, "Watching", ""},
        {"terminal", "Show the raw bytes of a link of the running gateway, and send lines to it", add_terminal, "Watching",
         "  anoctl terminal fc --end lf\n"},
        {"top", "Show the channels and addresses of the running gateway, live", add_top, "Watching", ""},
        {"record", "Record the frames of the running gateway as pcapng, which Wireshark reads, or MCAP", add_record, "Recordings",
         "  anoctl record flight.mcap\n  anoctl record errors.pcapng --direction dropped --seconds 60\n"},
        {"recordings", "List, start, end, download and delete recordings made by the gateway", add_recordings, "Recordings",
         "  anoctl recordings start test\n  anoctl recordings end test\n  anoctl recordings get test.pcapng\n"},
        {"info", "Show the contents of a recording", add_info, "Recordings", ""},
        {"convert", "Convert a recording to CSV tables, JSON lines, pcapng or MCAP", add_convert, "Recordings",
         "  anoctl convert flight.mcap flight.csv --id euler\n"},
        {"replay", "Replay a recording on a link", add_replay, "Recordings", "  anoctl replay flight.mcap pty:/tmp/fc\n"},
        {"plot-udp", "Send the decoded frames to PlotJuggler", add_plot_udp, "Frames", ""},
        {"web", "Show how to reach the gateway from a browser or another program", add_web, "Gateway", ""},
        {"certificate", "Create certificates for tls links and the page: an authority, and one for each computer",
         add_certificate, "Gateway",
         "  sudo anoctl certificate                  this computer\n  sudo anoctl certificate vehicle2        another one\n  "
         "sudo anoctl certificate vehicle2 --renew\n"},
    }};
    return all;
}

namespace {

/// "; commands: decode, …"
std::string commands() {
    std::string all;
    for (const Subcommand& s : subcommands()) all += (all.empty() ? "; commands: " : ", ") + std::string{s.name};
    return all;
}

/// "; choices: a, b or c" from "a|b|c"; empty for a value without '|'.
std::string choices(std::string value) {
    const auto last = value.rfind('|');
    if (last == value.npos) return {};
    value.replace(last, 1, " or ");
    for (std::size_t at = 0; (at = value.find('|', at)) != value.npos;) value.replace(at, 1, ", ");
    return "; choices: " + value;
}

/// The message for a missing option or operand. `options`: those of the command that was chosen.
std::string what_is_missing(const CLI::RequiredError& e, const Options& options) {
    std::string name = e.what();    // "file is required"
    const auto end = name.find(" is required");
    if (end == name.npos || name.find(' ') < end) return "missing command" + commands();
    name.resize(end);
    const auto option = std::find_if(options.begin(), options.end(), [&](const Option& one) { return one.name == name; });
    for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (option != options.end() && option->value.find_first_of("|[") == std::string::npos)
        name = option->value;    // as in --help
    return "missing " + name + (option != options.end() ? choices(option->value) : std::string{});
}

/// "; 'e1.mcap' was read as a value of --id; …", if the last value of an option that consumes all words after it looks like a
/// file.
std::string misread_value_hint(const CLI::App& command, const Options& options) {
    for (const Option& option : options) {
        if (!std::holds_alternative<std::vector<std::string>*>(option.into)) continue;
        const std::vector<std::string> words = command.get_option(option.name)->results();
        if (words.empty() || words.back().find_first_of("./") == std::string::npos) continue;
        return "; " + ano::in_quotes(words.back()) + " was read as a value of " + option.name + "; place it before " +
               option.name;
    }
    return {};
}

/// An option of a command that was given before the command.
void reject_misplaced_option(int argc, const char* const* argv) {
    const std::string option = argv[1], name = option.substr(0, option.find('='));
    for (const std::string_view shared : {"-h", "--help", "-V", "--version"})
        if (name == shared) return;
    for (int i = 2; i < argc; ++i)
        for (const Subcommand& s : subcommands())
            if (s.name == std::string_view{argv[i]})
                throw UsageError{"place " + name + " after the command: anoctl " + s.name + " " + option + " ..."};
}

void reject_unknown_command(int argc, const char* const* argv) {
    if (argc < 2) throw UsageError{"missing command" + commands() + "; for help: anoctl COMMAND --help"};
    for (const std::string_view shared : {"--json", "--control"})
        if (std::string_view{argv[1]}.starts_with(shared))
            throw UsageError{std::string{shared} + " requires a command" + commands()};
    if (argv[1][0] == '-') return reject_misplaced_option(argc, argv);
    std::vector<std::string_view> names;
    for (const Subcommand& s : subcommands()) {
        if (s.name == std::string_view{argv[1]}) return;
        names.emplace_back(s.name);
    }
    throw UsageError{"unknown command " + ano::in_quotes(argv[1]) + ano::did_you_mean(argv[1], names) + commands()};
}

// Prefix of negative numbers: CLI11 would parse -1.5 as options.
constexpr char negative_mark = '\x01';

bool is_negative_number(std::string_view word) { return word.starts_with('-') && ano::parse_number(word).has_value(); }
std::string unmarked(std::string word) {
    if (word.starts_with(negative_mark)) word.erase(0, 1);
    return word;
}
/// Marks each negative number in `words`, so that it is not parsed as an option; `kept` owns the new words.
void mark_negative_numbers(std::vector<const char*>& words, std::vector<std::string>& kept) {
    kept.reserve(words.size());
    for (const char*& word : words)
        if (is_negative_number(word)) word = kept.emplace_back(negative_mark + std::string{word}).c_str();
}

/// Moves --json and --control PATH behind the subcommand, and turns "help decode" into "decode --help", and
/// "web --make-certificate", the former name, into "certificate".
std::vector<const char*> as_meant(int argc, const char* const* argv) {
    std::vector<const char*> words{argv, argv + argc};
    if (argc > 1 && std::string_view{argv[1]} == "help") {
        words.erase(words.begin() + 1);
        words.push_back("--help");
        return words;
    }
    const auto first = words.begin() + std::min(argc, 1);
    auto command = first;
    while (command != words.end()) {
        const std::string_view word = *command;
        if (word == "--control" && command + 1 != words.end()) ++command;
        else if (word != "--json" && !word.starts_with("--control=")) break;
        ++command;
    }
    if (command != words.end()) std::rotate(first, command, command + 1);
    if (first != words.end() && std::string_view{*first} == "web" &&
        std::erase(words, std::string_view{"--make-certificate"}) > 0)
        *first = "certificate";
    return words;
}

CLI::Option* declare(CLI::App& app, const std::string& name, const Option::Into& into, const std::string& help) {
    if (const auto* flag = std::get_if<bool*>(&into)) return app.add_flag(name, **flag, help);
    if (const auto* word = std::get_if<std::string*>(&into)) return app.add_option(name, **word, help);
    if (const auto* word = std::get_if<std::optional<std::string>*>(&into)) return app.add_option(name, **word, help);
    if (const auto* words = std::get_if<std::vector<std::string>*>(&into)) return app.add_option(name, **words, help);
    return app.add_option_function<std::string>(
        name,
        [name, read = std::get<Option::Read>(into)](const std::string& word) {
            if (const std::string wrong = read(word); !wrong.empty()) throw CLI::ValidationError{name, wrong};
        },
        help);
}

/// Every command accepts --control, even if it sends no request to a gateway: an alias with --control then works for all
/// commands.
void allow_control(CLI::App& command) {
    if (command.get_option_no_throw("--control") == nullptr)
        command.add_option_function<std::string>("--control", [](const std::string&) {})->group("");    // not in --help
}

void declare(CLI::App& app, const Options& options) {
    for (const Option& option : options) {
        CLI::Option* declared = declare(app, option.name, option.into, option.help)->required(option.required);
        if (!option.value.empty()) declared->transform(unmarked);
        if (!option.value.empty()) declared->option_text(option.value);
    }
    for (const Option& option : options)
        for (const std::string& other : option.excludes) app.get_option(option.name)->excludes(app.get_option(other));
}

/// The only name that begins with the same three letters (--seconds for --secs). Empty: none, or several.
std::string beginning_alike(const std::string& given, const std::vector<std::string>& names) {
    constexpr std::size_t alike = 5;    // with "--"
    std::string found;
    for (const std::string& name : names) {
        if (given.size() < alike || name.compare(0, alike, given, 0, alike) != 0) continue;
        if (!found.empty()) return {};
        found = name;
    }
    return found;
}

/// The message for an error of the option parser.
std::string format_error(const CLI::ParseError& error, const CLI::App& command) {
    std::string what = error.what();
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && what.ends_with(" missing"))
        return what.substr(0, what.find(':')) + ": missing value";
    if (dynamic_cast<const CLI::ExtrasError*>(&error) == nullptr) return what;
    std::vector<std::string> extras = command.remaining(true);
    std::transform(extras.begin(), extras.end(), extras.begin(), unmarked);
    const auto option = std::find_if(extras.begin(), extras.end(), [](const std::string& word) { return word.starts_with('-'); });
    if (option == extras.end()) return extras.empty() ? what : "unexpected argument " + ano::in_quotes(extras.front());
    std::vector<std::string> names;
    for (const CLI::Option* known : command.get_options())
        for (const std::string& name : known->get_lnames()) names.push_back("--" + name);
    const std::string name = option->substr(0, option->find('='));
    std::string meant = ano::did_you_mean(name, std::vector<std::string_view>{names.begin(), names.end()});
    if (const std::string begins = beginning_alike(name, names); meant.empty() && !begins.empty())
        meant = " (did you mean " + ano::in_quotes(begins) + "?)";
    return "unknown option " + ano::in_quotes(name) + meant;
}

/// "; to work without a gateway, add --link LINK", for a command that can open a link itself. A --link with several values is a
/// filter and doesn't count.
std::string way_without(const std::string& command, const Options& options) {
    std::string words = "anoctl " + command;
    for (const Option& option : options) {
        if (option.name == "--link" && std::holds_alternative<std::string*>(option.into))
            return "; to work without a gateway, add --link LINK";
        if (option.name == "link") return "; to work without a gateway: " + words + " LINK";
        if (option.required) words += " " + option.value;
    }
    return {};
}

/// The message for a failure of the `chosen` command. If no gateway is running, also says how to start one or work without it.
std::string with_a_way_out(const std::string& what, const std::string& chosen, const Options& options) {
    if (!what.starts_with("no gateway is running at ")) return what;
    return what + "; to start one: anogated LINK..." + way_without(chosen, options);
}

/// False, with a message, if the output can't be written.
bool flushed(Streams& streams) {
    const bool is_written{streams.out.flush()};
    if (!is_written) print_note(streams, "cannot write the output");
    return is_written;
}

}    // namespace

std::uint8_t message_id_of(const std::string& word, const std::string& where) {
    const auto id = ano::message_id(word);
    if (const auto* fault = std::get_if<ano::JsonFault>(&id))
        throw UsageError{where + fault->what + (fault->what.ends_with("?)") ? "" : "; to list them: anoctl messages")};
    return std::get<std::uint8_t>(id);
}

bool use_color(const char* no_color, const char* term) noexcept {
    const bool refused = no_color != nullptr && *no_color != '\0';
    return !refused && term != nullptr && std::string_view{term} != "dumb";
}

int run(int argc, const char* const* given, Streams& streams) {
    if (argc > 1 && std::string_view{given[1]} == complete_command)
        return complete(std::span{given, static_cast<std::size_t>(argc)}.subspan(2), streams);
    std::vector<const char*> words = as_meant(argc, given);
    std::vector<std::string> kept;
    mark_negative_numbers(words, kept);
    const char* const* argv = words.data();
    argc = static_cast<int>(words.size());
    CLI::App app{"Command-line tool for ANO V8 frames and the anogate gateway", "anoctl"};
    app.set_version_flag("-V,--version", "anoctl " ANOGATE_VERSION);
    app.require_subcommand(1);
    std::vector<std::pair<CLI::App*, Run>> runs;
    std::map<const CLI::App*, Options> declared;
    for (const Subcommand& s : subcommands()) {
        CLI::App* command = app.add_subcommand(s.name, s.description)->group(s.group);
        Options options;
        runs.emplace_back(command, s.add(options));
        declare(*command, options);
        allow_control(*command);
        if (*s.examples != '\0') command->footer(std::string{"Examples:\n"} + s.examples);
        declared.emplace(command, std::move(options));
    }
    app.footer(    // not for subcommands, which don't have all of these options
        "Examples:\n"
        "  anoctl status                                  is everything in order?\n"
        "  anoctl monitor --id euler --count 10           ten frames of one message\n"
        "  anoctl param set --device 0xDC PID_P 4.5       then: anoctl param save\n"
        "  anoctl record flight.mcap --seconds 60\n"
        "  anoctl COMMAND --help                          options and examples of a command\n\n"
        "Global options (before or after the command):\n"
        "  --json           print one JSON object per line\n"
        "  --control PATH   control socket of the gateway\n\n"
        "The environment variable NO_COLOR disables colors.");
    const auto complain = [&](const std::string& what, int code) {
        print_note(streams, what);
        return code;
    };
    const auto fail = [&](const std::string& what, int code) {
        const auto chosen = app.get_subcommands();
        return complain(chosen.empty() ? what : with_a_way_out(what, chosen.front()->get_name(), declared[chosen.front()]), code);
    };
    try {
        reject_unknown_command(argc, argv);
        app.parse(argc, argv);
        for (const auto& [command, run] : runs) {
            if (!command->parsed()) continue;
            const int code = run(streams);
            return flushed(streams) ? code : failed;
        }
        return usage;
    } catch (const CLI::Success& e) {
        app.exit(e, streams.out, streams.err);
        return flushed(streams) ? fine : failed;
    } catch (const CLI::RequiredError& e) {
        const auto unknown = app.remaining();
        const auto chosen = app.get_subcommands();
        const bool stranger = chosen.empty() && !unknown.empty();
        complain(stranger         ? "unknown option " + ano::in_quotes(unknown[0])
                 : chosen.empty() ? what_is_missing(e, {})
                                  : what_is_missing(e, declared[chosen.front()]) +
                                        misread_value_hint(*chosen.front(), declared[chosen.front()]),
                 usage);
        streams.err << "Run with --help for more information.\n";
        return usage;
    } catch (const CLI::ParseError& e) {
        const auto chosen = app.get_subcommands();
        complain(format_error(e, chosen.empty() ? app : *chosen.front()), usage);
        streams.err << "Run with --help for more information.\n";
        return usage;
    } catch (const UsageError& e) {
        return fail(e.what(), usage);
    } catch (const Interrupted& e) {
        return complain(e.what(), interrupted);
    } catch (const std::exception& e) {
        return fail(e.what(), failed);
    }
}

}    // namespace anoctl
