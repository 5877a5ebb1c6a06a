// A file of a recording on the disk. Every call may block.
#pragma once
#include <ano/fault.hpp>
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
    int error = 0;    // errno
    ano::Fault fault;
};

/// The file contains complete parts only: a part that could not be written completely is removed. It is locked (flock) while it
/// is
/// open.
class RecordingFile {
public:
    /// Creates a new file (0640) and never opens an existing one: uses the first free name from `number` on, and sets `number` to
    /// that of the name. Creates the folder (0750) if it is missing.
    static std::variant<RecordingFile, DiskFault> create(const std::string& folder, const std::string& name,
                                                         RecordingFormat format, unsigned& number);

    const std::string& path() const noexcept { return path_; }
    std::uint64_t size() const noexcept { return size_; }
    /// Returns 0, or the errno; after an error no byte of `bytes` is in the file.
    int append(std::string_view bytes);
    /// Syncs the file, so that it survives a power failure. Returns 0, or the errno; after an error data since the last sync()
    /// may be lost.
    int sync();
    /// Truncates the file to `size` bytes, if the disk permits it.
    void cut(std::uint64_t size);
    /// False: the file was removed, or its path leads to something else.
    bool is_there() const;
    void remove();

private:
    RecordingFile(UniqueFd fd, std::string path) : fd_{std::move(fd)}, path_{std::move(path)} {}

    UniqueFd fd_;
    std::string path_;
    std::uint64_t size_ = 0;
};

/// Free bytes, for users other than root, of the disk that contains `folder` or would contain it; std::nullopt: not known.
std::optional<std::uint64_t> free_bytes(const std::string& folder);

}    // namespace anogate
