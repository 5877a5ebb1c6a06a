#include "recording_output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <ostream>
#include <system_error>

namespace anoctl {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

}    // namespace

std::string ending_refused(const std::string& file) {
    return file +
           ": recordings are pcapng (for Wireshark) or MCAP; name the file .pcapng or .mcap. To get other formats, use anoctl "
           "convert afterwards";
}

RecordingOutput::RecordingOutput(const std::string& path, bool force, Streams& streams) : path_{path}, streams_{streams} {
    if (path.empty()) throw UsageError{"FILE is an empty name"};
    if (path == "-") return;
    constexpr int flags = O_WRONLY | O_CREAT | O_CLOEXEC | O_NOCTTY;
    fd_ = ::open(path.c_str(), flags | O_EXCL, 0666);
    is_new_ = fd_ >= 0;
    if (fd_ < 0 && errno == EEXIST && !force) throw UsageError{path + " already exists; use --force to overwrite it"};
    if (fd_ < 0 && errno == EEXIST) fd_ = ::open(path.c_str(), flags, 0666);
    if (fd_ < 0) throw UsageError{path + ": cannot write: " + reason(errno)};
}

RecordingOutput::~RecordingOutput() {
    if (fd_ >= 0) ::close(fd_);
}

// An existing file is kept until the first write. Only regular files can be truncated.
void RecordingOutput::begin() {
    if (size_ == 0 && !is_new_ && ::ftruncate(fd_, 0) != 0 && errno != EINVAL) fault_ = reason(errno);
}

void RecordingOutput::write(std::string_view parts) {
    if (!fault_.empty() || parts.empty()) return;
    if (fd_ < 0) {
        if (!streams_.out.write(parts.data(), static_cast<std::streamsize>(parts.size())).flush())
            fault_ = "the reader closed the pipe";
        else size_ += parts.size();
        return;
    }
    begin();
    std::string_view rest = parts;
    while (fault_.empty() && !rest.empty()) {
        const ssize_t n = ::write(fd_, rest.data(), rest.size());
        if (n > 0) rest.remove_prefix(static_cast<std::size_t>(n));
        else if (n == 0 || errno != EINTR) fault_ = reason(n == 0 ? EIO : errno);
    }
    if (rest.empty()) size_ += parts.size();
    else if (::ftruncate(fd_, static_cast<off_t>(size_)) != 0) return;    // readers ignore an incomplete block at the end
}

void RecordingOutput::sync() {
    if (fd_ < 0 || !fault_.empty()) return;
    if (::fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS) fault_ = reason(errno);    // EINVAL, EROFS: not a plain file
}

void RecordingOutput::remove_if_empty() {
    if (is_new_ && size_ == 0) ::unlink(path_.c_str());
}

}    // namespace anoctl
