#include <sys/errors.hpp>
#include <sys/files/read_file.hpp>
#include <sys/files/write_all.hpp>
#include <sys/files/write_atomically.hpp>
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <system_error>

namespace anogate {
namespace {

namespace fs = std::filesystem;

std::string unfinished_of(const std::string& path) { return path + ".new"; }

bool sync_folder(const fs::path& file) {
    const UniqueFd folder{::open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    return folder && ::fsync(folder.get()) == 0;
}

}    // namespace

std::string write_atomically(const std::string& path, std::span<const std::uint8_t> bytes) {
    if (path.empty()) return "there is no folder for it ($STATE_DIRECTORY, $XDG_STATE_HOME and $HOME are not set)";
    std::error_code ec;
    fs::create_directories(fs::path{path}.parent_path(), ec);
    if (ec) return error_text(fs::path{path}.parent_path().string(), ec.value());
    const std::string unfinished = unfinished_of(path);
    ::unlink(unfinished.c_str());    // not opened: it may be a pipe, which would block
    const UniqueFd file{::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600)};
    const std::string_view text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    if (file && write_all(file.get(), text) && std::rename(unfinished.c_str(), path.c_str()) == 0 && sync_folder(path)) return {};
    const int error = errno;
    ::unlink(unfinished.c_str());
    return error_text(path, error);
}

std::optional<std::string> read_kept_file(const std::string& path, std::size_t max_bytes, std::string& fault) {
    std::error_code ec;
    if (!path.empty()) ::unlink(unfinished_of(path).c_str());
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
