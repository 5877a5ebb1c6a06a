// A file of a recording on its disk. Every call may block.
#pragma once
#include <record/recording_writer.hpp>
#include <sys/unique_fd.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace anogate {

/// A failed operation of the disk.
struct DiskFault {
    int error = 0;       // errno
    std::string text;    // where and why, in a clause
};

/// The file has complete parts only: nothing remains of a part that does not fit. It is locked (flock) while it is open.
class RecordingFile {
public:
    /// Creates a new file (0640); never opens an existing one: takes the first free name from `number` on, and sets `number` to the one of
    /// that name. Makes the folder (0750) when it is missing.
    static std::variant<RecordingFile, DiskFault> create(const std::string& folder, const std::string& name,
                                                         RecordingFormat format, unsigned& number);

    const std::string& path() const noexcept { return path_; }
    std::uint64_t size() const noexcept { return size_; }
    /// Returns 0, or the errno; then nothing of `bytes` is in the file.
    int append(std::string_view bytes);
    /// Syncs the file, so that it survives a loss of power. Returns 0, or the errno; then data since the last sync() may be missing.
    int sync();
    /// Cuts the file to `size` bytes, if the disk permits it.
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

/// Free bytes, for users other than root, of the disk with `folder` or on which it would be made; std::nullopt: not known.
std::optional<std::uint64_t> free_bytes(const std::string& folder);

}    // namespace anogate
