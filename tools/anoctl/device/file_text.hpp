// Files that a command reads and writes whole.
#pragma once
#include <cstddef>
#include <string>

namespace anoctl {

/// "-" is standard input. Throws UsageError when it can't be read or has more than `most` bytes.
std::string text_of_file(const std::string& path, std::size_t most = 64 * 1024 * 1024);

/// Whole or not at all: who reads it meanwhile has the old one. Throws Failure.
void write_file(const std::string& path, const std::string& text);

}    // namespace anoctl
