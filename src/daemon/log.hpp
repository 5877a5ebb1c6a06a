// Where the log goes and what it looks like.
#pragma once
#include <gateway/settings.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// How much something matters, as syslog counts it.
enum class Priority { error = 3, warning = 4, info = 6, debug = 7 };

/// Standard error, or a rotated file. The journal has times of its own, and is told the priority of every line instead. From here on
/// who logs never waits for where it goes (LogWriter).
void start_log(const LogSettings& settings);

/// Waits for what was said, LogWriter::patience at most. False: the log has not taken it, and exit() might wait for it too; _exit() does not.
bool end_log();

/// Says it on standard error, as the log would: for what comes before start_log(), and for faults that end the program.
void say(Priority priority, std::string_view lines);

/// Every line of `text` as the journal reads it: "<4>text". Whatever the text begins with, its priority is this one.
std::string journal_lines(Priority priority, std::string_view text);

}    // namespace anogate
