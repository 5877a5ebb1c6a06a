#include <sys/files/read_file.hpp>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>

namespace anogate {
namespace {

namespace fs = std::filesystem;

// Opening a pipe would wait for somebody who writes, and reading a device may never end.
bool is_file(const std::string& path, std::error_code& error) {
    const fs::file_status is = fs::status(path, error);
    if (error || fs::is_regular_file(is)) return !error;
    error = make_error_code(fs::is_directory(is) ? std::errc::is_a_directory : std::errc::operation_not_supported);
    return false;
}

}    // namespace

std::string read_file(const std::string& path, std::size_t max_bytes, std::error_code& error) {
    if (!is_file(path, error)) return {};
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{std::fopen(path.c_str(), "re"), std::fclose};
    if (!file) {
        error.assign(errno, std::system_category());
        return {};
    }
    std::string text;
    char piece[16 * 1024];
    while (const std::size_t count = std::fread(piece, 1, sizeof piece, file.get())) {
        text.append(piece, count);
        if (text.size() > max_bytes) {
            error = make_error_code(std::errc::file_too_large);
            return {};
        }
    }
    if (std::ferror(file.get()) != 0) error.assign(errno, std::system_category());
    return text;
}

}    // namespace anogate
