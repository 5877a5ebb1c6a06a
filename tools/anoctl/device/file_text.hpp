// Reads and writes whole files.
#pragma once
#include <cstddef>
#include <string>

namespace anoctl {

struct Streams;

/// "-" is standard input. Throws UsageError when it can't be read or has more than `max_bytes`.
std::string text_of_file(const std::string& path, std::size_t max_bytes = 64 * 1024 * 1024);

/// The same; when standard input is a terminal, first prints that it waits for `what`.
std::string given_text(const std::string& path, const std::string& what, Streams& streams);

/// Whether a plain file of this name exists, which would be lost; false for "-".
bool is_file(const std::string& path);

/// Replaces the file atomically: a reader sees the old or the new content. Writes into a file that is not plain, as /dev/stdout. Throws
/// Failure.
void write_file(const std::string& path, const std::string& text);

}    // namespace anoctl
