#include <config/read_file.hpp>

#include <cerrno>
#include <cstdio>
#include <memory>

namespace anogate {

std::string read_file(const std::string& path, std::size_t max_bytes, std::error_code& error) {
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
