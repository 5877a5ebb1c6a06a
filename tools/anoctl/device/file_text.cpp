#include "file_text.hpp"

#include <anoctl/anoctl.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

namespace anoctl {
namespace {

std::string why() { return std::generic_category().message(errno); }

}    // namespace

std::string text_of_file(const std::string& path, std::size_t most) {
    const int fd = path == "-" ? ::dup(STDIN_FILENO) : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) throw UsageError{path + ": it can't be read: " + why()};
    std::string text;
    char room[64 * 1024];
    ssize_t n = 0;
    while ((n = ::read(fd, room, sizeof room)) > 0 && text.size() <= most) text.append(room, static_cast<std::size_t>(n));
    const std::string fault = n < 0 ? why() : "";
    ::close(fd);
    if (!fault.empty()) throw UsageError{path + ": it can't be read: " + fault};
    if (text.size() > most) throw UsageError{path + ": it has more than " + std::to_string(most >> 20) + " MiB"};
    return text;
}

void write_file(const std::string& path, const std::string& text) {
    const std::string part = path + ".part";
    std::FILE* file = std::fopen(part.c_str(), "we");
    bool good = file != nullptr && std::fwrite(text.data(), 1, text.size(), file) == text.size();
    if (file != nullptr) good = std::fclose(file) == 0 && good;
    if (good && std::rename(part.c_str(), path.c_str()) == 0) return;
    const std::string fault = why();
    ::unlink(part.c_str());
    throw Failure{path + ": it can't be written: " + fault};
}

}    // namespace anoctl
