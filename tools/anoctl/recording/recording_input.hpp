// Reads a recording from its begin to its end.
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

/// The facts that are known after reading everything.
struct RecordingFacts {
    anogate::RecordingFormat format = anogate::RecordingFormat::pcapng;
    anogate::RecordingHead head;
    std::uint64_t size = 0;       // of the file, bytes
    std::uint64_t read = 0;       // bytes of it that were understood
    bool has_end = false;         // the recording was ended regularly
    std::uint64_t foreign = 0;    // packets that are not frames
    std::string fault;            // why nothing is read behind `read`; empty: everything was read
    anogate::SkippedParts skipped{};
    std::vector<std::string_view> mismatches{};    // of checksums, as clauses; found only when everything was read

    /// Part of it can't be read, or has changed since it was written.
    bool is_damaged() const { return !fault.empty() || skipped.count > 0 || !mismatches.empty(); }
    /// "it was not ended: …", "damaged behind …", lines for people.
    std::vector<std::string> notes() const;
};

/// Reads item by item, in any format, which its first bytes tell. "-" is standard input. A file that is still written is read up to its
/// present end.
class RecordingInput {
public:
    /// Throws UsageError when it can't be read.
    RecordingInput(const std::string& path, Streams& streams);
    ~RecordingInput();
    RecordingInput(const RecordingInput&) = delete;
    RecordingInput& operator=(const RecordingInput&) = delete;

    /// The next item, valid until the next call; std::nullopt: there are no more. Throws Failure when it is no recording.
    std::optional<anogate::Recorded> next();
    /// The facts about the part that was read.
    RecordingFacts facts() const;
    const anogate::RecordingHead& head() const noexcept { return reader_->head(); }

private:
    bool read();

    std::string path_;
    int fd_;
    std::vector<char> room_;
    std::unique_ptr<anogate::RecordingReader> reader_;    // chosen by the first bytes; until then a reader without input
    std::uint64_t size_ = 0;
};

/// The content of the index of a recording, if it has one and is a seekable file; otherwise the whole recording must be read.
struct IndexedRecording {
    RecordingFacts facts;
    anogate::RecordingCounts counts;
};
std::optional<IndexedRecording> read_index(const std::string& path);

/// Reads to the end, and passes each item to `take`, with the head of its recording.
using TakeRecorded = std::function<void(const anogate::Recorded& item, const anogate::RecordingHead& head)>;
RecordingFacts read_recording(const std::string& path, Streams& streams, const TakeRecorded& take);

}    // namespace anoctl
