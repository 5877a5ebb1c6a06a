// Reads and writes whole files.
#pragma once
#include <cstddef>
#include <string>

namespace anoctl {

struct Streams;

/// Opens a file for reading; -1 and errno if that fails. Throws UsageError for a named pipe, since opening it waits for a writer, and
/// for other files that are not regular. Those in /dev and /proc are accepted: bash's <(command) is a pipe there. Reading a folder
/// fails.
int open_input(const std::string& path);

/// Reads a file; "-" is standard input. Throws UsageError if it is not readable or is larger than `max_bytes`.
std::string read_text_file(const std::string& path, std::size_t max_bytes = 64 * 1024 * 1024);

/// The same; if standard input is a terminal, first prints that it waits for `what`.
std::string read_input(const std::string& path, const std::string& what, Streams& streams);

/// Whether a regular file of this name exists, which would be overwritten; false for "-".
bool is_file(const std::string& path);

/// Replaces the file atomically: readers see either the old or the new content. Writes directly into a file that is not regular,
/// as /dev/stdout. Throws Failure.
void write_file(const std::string& path, const std::string& text);

}    // namespace anoctl
