#include <config/read_file.hpp>
#include <daemon/kept_file.hpp>
#include <link/errors.hpp>
#include <link/unique_fd.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace anogate {
namespace {

namespace fs = std::filesystem;

bool write_all(int fd, std::span<const std::uint8_t> bytes) {
    for (std::size_t at = 0; at < bytes.size();) {
        const ssize_t n = ::write(fd, bytes.data() + at, bytes.size() - at);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += static_cast<std::size_t>(n);
    }
    return ::fsync(fd) == 0;
}

bool sync_folder(const fs::path& file) {
    const UniqueFd folder{::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    return folder && ::fsync(folder.get()) == 0;
}

}    // namespace

std::string keep_file(const std::string& path, std::span<const std::uint8_t> bytes) {
    if (path.empty()) return "there is no folder for it ($STATE_DIRECTORY, $XDG_STATE_HOME and $HOME are not set)";
    std::error_code ec;
    fs::create_directories(fs::path{path}.parent_path(), ec);
    if (ec) return error_text(fs::path{path}.parent_path().string(), ec.value());
    const std::string unfinished = path + ".new";
    ::unlink(unfinished.c_str());    // it may be anything: opening a pipe would block
    const UniqueFd file{::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600)};
    if (file && write_all(file.get(), bytes) && std::rename(unfinished.c_str(), path.c_str()) == 0 && sync_folder(path))
        return {};
    return error_text(path, errno);
}

std::optional<std::string> read_kept_file(const std::string& path, std::size_t max_bytes, std::string& fault) {
    std::error_code ec;
    const fs::file_status status = path.empty() ? fs::file_status{fs::file_type::not_found} : fs::status(path, ec);
    if (status.type() == fs::file_type::not_found) return std::nullopt;
    if (!ec && !fs::is_regular_file(status)) fault = path + ": is not a file";
    std::string text = ec || !fault.empty() ? std::string{} : read_file(path, max_bytes, ec);
    if (ec) fault = path + ": " + ec.message();
    return fault.empty() ? std::optional{std::move(text)} : std::nullopt;
}

std::string forget_file(const std::string& path) {
    if (path.empty() || ::unlink(path.c_str()) == 0) {
        if (!path.empty()) sync_folder(path);
        return {};
    }
    return errno == ENOENT || errno == ENOTDIR ? "" : error_text(path, errno);
}

}    // namespace anogate
