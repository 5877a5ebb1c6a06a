// Files of the source tree, and what a file holds.
#pragma once
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace support {

/// `path` is relative to the top of the source tree.
inline std::filesystem::path source_file(const std::string& path) { return std::filesystem::path{ANOGATE_SOURCE_DIR} / path; }

inline std::string text_of(const std::filesystem::path& path) {
    std::ifstream file{path, std::ios::binary};
    return {std::istreambuf_iterator<char>{file}, {}};
}

}    // namespace support
