// Files of the source tree, and the content of files.
#pragma once
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

namespace support {

/// `path` is relative to the top of the source tree.
inline std::filesystem::path source_file(const std::string& path) { return std::filesystem::path{ANOGATE_SOURCE_DIR} / path; }

inline std::string file_text(const std::filesystem::path& path) {
    std::ifstream file{path, std::ios::binary};
    std::ostringstream text;
    text << file.rdbuf();    // in large pieces: with a sanitizer, byte by byte takes seconds
    return std::move(text).str();
}

}    // namespace support
