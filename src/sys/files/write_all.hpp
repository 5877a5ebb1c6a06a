// Writes a whole text to a file.
#pragma once
#include <string_view>

#include <unistd.h>

#include <cerrno>

namespace anogate {

/// Writes all of `text` and syncs the file to its disk. False: see errno; ENOSPC also if only a part could be written.
inline bool write_all(int fd, std::string_view text) noexcept {
    while (!text.empty()) {
        const ssize_t n = ::write(fd, text.data(), text.size());
        if (n < 0 && errno == EINTR) continue;
        if (n == 0) errno = ENOSPC;
        if (n <= 0) return false;
        text.remove_prefix(static_cast<std::size_t>(n));
    }
    return ::fsync(fd) == 0;
}

}    // namespace anogate
