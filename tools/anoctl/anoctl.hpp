// The command-line tool: one file a subcommand, one row in the table of subcommands.
#pragma once
#include "options.hpp"

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <span>
#include <stdexcept>
#include <string>

namespace anoctl {

enum Exit : int {
    fine = 0,
    failed = 1,    // the work: nothing decoded, no answer, refused
    usage = 2,
};

/// Where a subcommand reads and writes.
struct Streams {
    int in;    // a file descriptor: live input is read as it comes
    std::ostream& out;
    std::ostream& err;
    bool terminal = false;          // `out` is one: columns
    bool color = false;             // and colours
    bool in_is_terminal = false;    // somebody would have to type
};

/// What the user gave can't be meant: one line on `err`, exit 2.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// The work can't be done: one line on `err`, exit 1.
struct Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

using Run = std::function<int(Streams&)>;

struct Subcommand {
    const char* name;
    const char* description;
    Run (*add)(Options& options);    // declares its options; what it returns is run when the subcommand is chosen
};

Run add_decode(Options& options);
Run add_encode(Options& options);
Run add_messages(Options& options);
Run add_monitor(Options& options);

std::span<const Subcommand> subcommands() noexcept;

/// The id of a message by name or number. Throws UsageError, with `where` before what is wrong.
std::uint8_t message_id_of(const std::string& word, const std::string& where = {});

/// Whether a terminal is to be written to in colour, by what the environment says (null: nothing). NO_COLOR that is not
/// empty, and a terminal without abilities, mean no.
bool wants_color(const char* no_color, const char* term) noexcept;

/// The whole program but for its process. Returns what it exits with.
int run(int argc, const char* const* argv, Streams& streams);

}    // namespace anoctl
