// Files that a command reads and writes whole.
#pragma once
#include <cstddef>
#include <string>

namespace anoctl {

struct Streams;

/// "-" is standard input. Throws UsageError when it can't be read or has more than `max_bytes`.
std::string text_of_file(const std::string& path, std::size_t max_bytes = 64 * 1024 * 1024);

/// The same of what somebody gives: at a terminal, standard input says that it waits for `what`.
std::string given_text(const std::string& path, const std::string& what, Streams& streams);

/// There is a file of this name that would be lost; "-" is none, nor is what is no plain file.
bool is_file(const std::string& path);

/// Whole or not at all: who reads it meanwhile has the old one. What is no plain file, as /dev/stdout, is written into. Throws Failure.
void write_file(const std::string& path, const std::string& text);

}    // namespace anoctl
