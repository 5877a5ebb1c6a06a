// The command-line tool: each subcommand is one file and one row in the table of subcommands.
#pragma once
#include "options.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <span>
#include <stdexcept>
#include <string>

namespace anoctl {

enum Exit : int {
    fine = 0,
    failed = 1,    // the command failed: nothing decoded, no answer, refused
    usage = 2,     // a usage error
    interrupted = 130,
};

/// Input and output of a subcommand.
struct Streams {
    int in;    // a file descriptor: live input is read as it arrives
    std::ostream& out;
    std::ostream& err;
    bool terminal = false;          // `out` is a terminal: print columns
    bool color = false;             // use colours
    bool in_is_terminal = false;    // input would have to be typed
    bool err_is_terminal = false;
    std::size_t width = 80;    // cells of a line of the terminal
};

/// A usage error: one line on `err`, exit status 2.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// The command failed: one line on `err`, exit status 1.
struct Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Cancelled by Ctrl-C: one line on `err` that says which parts are incomplete, exit status 130.
struct Interrupted : std::runtime_error {
    using std::runtime_error::runtime_error;
};

using Run = std::function<int(Streams&)>;

struct Subcommand {
    const char* name;
    const char* description;
    Run (*add)(Options& options);    // declares its options; returns the function that runs the subcommand
    const char* group;               // heading in the list of subcommands of --help
    const char* examples;            // lines; "": none
};

Run add_decode(Options& options);
Run add_encode(Options& options);
Run add_messages(Options& options);
Run add_monitor(Options& options);
Run add_plot_udp(Options& options);
Run add_ports(Options& options);
Run add_setup(Options& options);
Run add_certificate(Options& options);
Run add_record(Options& options);
Run add_recordings(Options& options);
Run add_replay(Options& options);
Run add_send(Options& options);
Run add_terminal(Options& options);
Run add_top(Options& options);
Run add_status(Options& options);
Run add_alarms(Options& options);
Run add_calibrate(Options& options);
Run add_convert(Options& options);
Run add_command(Options& options);
Run add_devices(Options& options);
Run add_flash(Options& options);
Run add_image(Options& options);
Run add_info(Options& options);
Run add_links(Options& options);
Run add_log(Options& options);
Run add_param(Options& options);
Run add_waypoint(Options& options);
Run add_routes(Options& options);
Run add_metrics(Options& options);
Run add_flexible(Options& options);
Run add_reload(Options& options);
Run add_web(Options& options);

std::span<const Subcommand> subcommands() noexcept;

/// The id of a message from its name or number. Throws UsageError, whose text begins with `where`.
std::uint8_t message_id_of(const std::string& word, const std::string& where = {});

/// Whether a terminal gets colours. The arguments are the environment variables of these names (nullptr: not set). False if
/// NO_COLOR is set and not empty, or if `term` is "dumb".
bool use_color(const char* no_color, const char* term) noexcept;

/// Runs the program with these arguments. Returns the exit status.
int run(int argc, const char* const* argv, Streams& streams);

}    // namespace anoctl
