// A program xdg-open that simulates a browser with the page: it reads the file that redirects to the page, and signs in with its
// code.
#pragma once
#include <support/temp_dir.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace support {

/// Writes it to `dir`. It prints its URL argument, the mode of that file, the address to which the file redirects, and the
/// response of the gateway at `port`.
inline void write_signing_browser(const TempDir& dir, std::uint16_t port) {
    const std::string program = dir.write("xdg-open", R"sh(#!/bin/sh
echo "opens $1"
file=${1#file://}
stat -c 'mode %a' "$file"
sed -n 's/.*url=\(.*\)#once=.*/leads to \1/p' "$file"
code=$(sed -n 's/.*#once=\([0-9a-f]*\)".*/\1/p' "$file")
curl -sS -H 'Content-Type: application/json' -d "{\"code\": \"$code\"}" http://localhost:)sh" +
                                                          std::to_string(port) + "/login\n");
    std::filesystem::permissions(program, std::filesystem::perms{0700});
}

}    // namespace support
