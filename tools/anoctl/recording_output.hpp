// A file that grows while something is recorded or converted into it.
#pragma once
#include "anoctl.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace anoctl {

/// What is said of a new recording, `file`, that ends neither in .pcapng nor in .mcap.
std::string ending_refused(const std::string& file);

/// Of what is written, it holds whole parts only: when the disk is full, what does not fit whole is taken off again.
class RecordingOutput {
public:
    /// "-" is standard output. A file that is there is not touched: UsageError, unless `force`. Throws UsageError when it can't be made.
    RecordingOutput(const std::string& path, bool force, Streams& streams);
    ~RecordingOutput();
    RecordingOutput(const RecordingOutput&) = delete;
    RecordingOutput& operator=(const RecordingOutput&) = delete;

    /// Whole parts, as many as there are. Nothing is written after a fault.
    void write(std::string_view parts);
    /// Has it outlive a loss of power.
    void sync();
    /// Why it can't be written any more, in a clause; empty: it can.
    const std::string& fault() const noexcept { return fault_; }
    std::uint64_t size() const noexcept { return size_; }
    /// Removes a file into which nothing was written.
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
