// The output file of a recording or a conversion.
#pragma once
#include <anoctl/anoctl.hpp>

#include <cstdint>
#include <string>
#include <string_view>

namespace anoctl {

/// The error for a new recording whose name `file` ends neither in .pcapng nor in .mcap.
std::string ending_refused(const std::string& file);

/// The file contains only complete blocks: if a write fails because the disk is full, the incomplete block is removed.
class RecordingOutput {
public:
    /// "-" is standard output. Throws UsageError if the file can't be created, or if it exists and `force` is not set.
    RecordingOutput(const std::string& path, bool force, Streams& streams);
    ~RecordingOutput();
    RecordingOutput(const RecordingOutput&) = delete;
    RecordingOutput& operator=(const RecordingOutput&) = delete;

    /// Writes one or more complete blocks. Does nothing after a fault.
    void write(std::string_view parts);
    /// Syncs the file, so that it survives a loss of power.
    void sync();
    /// A clause: why the file can't be written any more. Empty: no fault.
    const std::string& fault() const noexcept { return fault_; }
    std::uint64_t size() const noexcept { return size_; }
    /// Removes a new file that is still empty.
    void remove_if_empty();

private:
    void begin();

    std::string path_;
    Streams& streams_;
    int fd_ = -1;    // -1: standard output
    bool is_new_ = false;
    std::uint64_t size_ = 0;
    std::string fault_;
};

}    // namespace anoctl
