// Reads a recording from beginning to end.
#pragma once
#include <anoctl/anoctl.hpp>

#include <record/recording_counts.hpp>
#include <record/recording_reader.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Known after the complete recording was read.
struct RecordingFacts {
    anogate::RecordingFormat format = anogate::RecordingFormat::pcapng;
    anogate::RecordingHead head;
    std::uint64_t size = 0;       // of the file, in bytes
    std::uint64_t read = 0;       // bytes read successfully
    bool has_end = false;         // the recording ended normally
    std::uint64_t foreign = 0;    // packets without a frame
    std::string fault;            // why nothing after `read` could be read; empty: no fault
    anogate::SkippedParts skipped{};
    std::vector<std::string_view> mismatches{};    // wrong checksums, as clauses; found only if the complete recording was read

    /// A part can't be read, or has changed since it was written.
    bool is_damaged() const { return !fault.empty() || skipped.count > 0 || !mismatches.empty(); }
    /// Lines for people: "not finished: …", "damaged after byte …".
    std::vector<std::string> notes() const;
};

/// Reads item by item. The format is detected from the first bytes. "-" is standard input. A file that is still being written is
/// read up to its current end.
class RecordingInput {
public:
    /// Throws UsageError if the file can't be read.
    RecordingInput(const std::string& path, Streams& streams);
    ~RecordingInput();
    RecordingInput(const RecordingInput&) = delete;
    RecordingInput& operator=(const RecordingInput&) = delete;

    /// The next item, valid until the next call; std::nullopt: end. Throws Failure if the file is not a recording.
    std::optional<anogate::Recorded> next();
    /// Facts about the part read so far.
    RecordingFacts facts() const;
    const anogate::RecordingHead& head() const noexcept { return reader_->head(); }

private:
    bool read();

    std::string path_;
    int fd_;
    std::vector<char> room_;
    std::unique_ptr<anogate::RecordingReader> reader_;    // chosen from the first bytes; before that, a reader without input
    std::uint64_t size_ = 0;
};

/// The index of a recording. read_index() returns std::nullopt if the file has none or is not seekable: then the complete
/// recording must be read.
struct IndexedRecording {
    RecordingFacts facts;
    anogate::RecordingCounts counts;
};
std::optional<IndexedRecording> read_index(const std::string& path);

/// Reads to the end, and passes each item to `accept` with the head of its recording.
using OnRecorded = std::function<void(const anogate::Recorded& item, const anogate::RecordingHead& head)>;
RecordingFacts read_recording(const std::string& path, Streams& streams, const OnRecorded& accept);

}    // namespace anoctl
