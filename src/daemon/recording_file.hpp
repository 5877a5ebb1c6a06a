// A file of a recording on its disk. Every call may block.
#pragma once
#include <link/unique_fd.hpp>
#include <record/recording_writer.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace anogate {

/// What a disk did not do.
struct DiskFault {
    int error = 0;       // errno
    std::string text;    // where and why, in a clause
};

/// It holds whole parts only: of one that does not fit, nothing stays. While it is open, it is locked (flock).
class RecordingFile {
public:
    /// A new one (0640), never one that is there: the first name that is free from `number` on, which is its number then. The
    /// folder is made when it is missing (0750).
    static std::variant<RecordingFile, DiskFault> create(const std::string& folder, const std::string& name,
                                                         RecordingFormat format, unsigned& number);

    const std::string& path() const noexcept { return path_; }
    std::uint64_t size() const noexcept { return size_; }
    /// 0, or the errno; nothing of `bytes` is in it then.
    int append(std::string_view bytes);
    /// Has it outlive a loss of power. 0, or the errno: what was appended since the last time may not be in it.
    int sync();
    /// Takes off what is behind `size`, as far as the disk does that.
    void cut(std::uint64_t size);
    /// False: it was removed, or something else stands at its path.
    bool is_there() const;
    void remove();

private:
    RecordingFile(UniqueFd fd, std::string path) : fd_{std::move(fd)}, path_{std::move(path)} {}

    UniqueFd fd_;
    std::string path_;
    std::uint64_t size_ = 0;
};

/// Of the disk that has that folder, or will have it, for those who are not root; nothing: it can't be told.
std::optional<std::uint64_t> free_bytes(const std::string& folder);

}    // namespace anogate
