#include <sys/files/read_file.hpp>
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <filesystem>

namespace anogate {
namespace {

namespace fs = std::filesystem;

// Opening a pipe would wait for a writer, and reading a device may never end.
bool is_file(const std::string& path, std::error_code& error) {
    const fs::file_status is = fs::status(path, error);
    if (error || fs::is_regular_file(is)) return !error;
    error = make_error_code(fs::is_directory(is) ? std::errc::is_a_directory : std::errc::operation_not_supported);
    return false;
}

}    // namespace

std::string read_file(const std::string& path, std::size_t max_bytes, std::error_code& error) {
    if (!is_file(path, error)) return {};
    const UniqueFd file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (!file) {
        error.assign(errno, std::system_category());
        return {};
    }
    std::string text;
    std::array<char, std::size_t{16} * 1024> piece{};
    while (true) {
        const ssize_t count = ::read(file.get(), piece.data(), piece.size());
        if (count == 0) return text;
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) {    // EAGAIN: /proc/kmsg and similar files have no end
            error = errno == EAGAIN ? make_error_code(std::errc::operation_not_supported)
                                    : std::error_code{errno, std::system_category()};
            return {};
        }
        text.append(piece.data(), static_cast<std::size_t>(count));
        if (text.size() > max_bytes) {
            error = make_error_code(std::errc::file_too_large);
            return {};
        }
    }
}

}    // namespace anogate
