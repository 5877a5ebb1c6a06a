// The destination of the log, and its format.
#pragma once
#include <gateway/settings.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// The priorities of syslog.
enum class Priority { error = 3, warning = 4, info = 6, debug = 7 };

/// Logs to standard error or to a rotated file. The journal has its own time stamps, so lines for it begin with the priority instead.
/// After this call, logging never blocks (LogWriter).
void start_log(const LogSettings& settings);

/// Waits until all lines are written, at most LogWriter::patience. False: not all are written, and exit() might block too; use
/// _exit().
bool end_log();

/// Writes to standard error, in the format of the log: for messages before start_log(), and for faults that end the program.
void print_lines(Priority priority, std::string_view lines);

/// Formats each line of `text` for the journal: "<4>text". A priority at the beginning of the text itself has no effect.
std::string journal_lines(Priority priority, std::string_view text);

}    // namespace anogate
