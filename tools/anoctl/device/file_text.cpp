#include "file_text.hpp"

#include <anoctl/anoctl.hpp>
#include <anoctl/say.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace anoctl {
namespace {

std::string why() { return std::generic_category().message(errno); }

}    // namespace

int open_input(const std::string& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    if (fd < 0) return fd;
    struct stat about {};
    const bool is_known = ::fstat(fd, &about) == 0;
    const bool is_of_system = path.starts_with("/dev/") || path.starts_with("/proc/");
    if (is_known && !S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode) && !is_of_system) {
        ::close(fd);
        throw UsageError{path + ": is not a regular file"};
    }
    ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) & ~O_NONBLOCK);
    return fd;
}

std::string read_text_file(const std::string& path, std::size_t max_bytes) {
    if (path.empty()) throw UsageError{"FILE is an empty name"};
    const int fd = path == "-" ? ::dup(STDIN_FILENO) : open_input(path);
    if (fd < 0) throw UsageError{path + ": cannot read: " + why()};
    std::string text;
    char room[64 * 1024];
    ssize_t n = 0;
    while ((n = ::read(fd, room, sizeof room)) > 0 && text.size() <= max_bytes) text.append(room, static_cast<std::size_t>(n));
    const std::string fault = n < 0 ? why() : "";
    ::close(fd);
    if (!fault.empty()) throw UsageError{path + ": cannot read: " + fault};
    if (text.size() > max_bytes) throw UsageError{path + ": larger than " + std::to_string(max_bytes >> 20) + " MiB"};
    return text;
}

std::string read_input(const std::string& path, const std::string& what, Streams& streams) {
    if (path == "-" && streams.in_is_terminal)
        print_note(streams, "reading " + what + " from standard input; finish with Ctrl-D at the start of a line");
    return read_text_file(path);
}

bool is_file(const std::string& path) {
    std::error_code error;
    return path != "-" && std::filesystem::is_regular_file(path, error);
}

void write_file(const std::string& path, const std::string& text) {
    namespace fs = std::filesystem;
    if (path.empty()) throw UsageError{"FILE is an empty name"};
    std::error_code error;
    const fs::file_status there = fs::status(path, error);
    const bool is_plain = !fs::exists(there) || fs::is_regular_file(there);
    const fs::path real = fs::is_regular_file(there) ? fs::canonical(path, error) : fs::path{path};    // follows a symbolic link
    const std::string target = error && real.empty() ? path : real.string();
    const std::string part = is_plain ? target + ".part" : target;
    std::FILE* file = std::fopen(part.c_str(), "we");
    bool good = file != nullptr && std::fwrite(text.data(), 1, text.size(), file) == text.size();
    if (file != nullptr) good = std::fclose(file) == 0 && good;
    if (good && !is_plain) return;
    if (good && fs::is_regular_file(there)) fs::permissions(part, there.permissions(), error);
    if (good && std::rename(part.c_str(), target.c_str()) == 0) return;
    const std::string fault = why();
    if (is_plain) ::unlink(part.c_str());
    throw Failure{path + ": cannot write: " + fault};
}

}    // namespace anoctl
