// A recording that is read from its begin to its end.
#pragma once
#include "anoctl.hpp"

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

/// What is known when all was read.
struct RecordingFacts {
    anogate::RecordingFormat format = anogate::RecordingFormat::pcapng;
    anogate::RecordingHead head;
    std::uint64_t size = 0;       // of the file, bytes
    std::uint64_t read = 0;       // of it, what was understood
    bool has_end = false;         // what recorded it ended it
    std::uint64_t foreign = 0;    // packets that are no frame
    std::string fault;            // why nothing is read behind that; empty: all was read
    anogate::SkippedParts skipped{};
    std::vector<std::string_view> mismatches{};    // of checksums, in clauses; found where all was read

    /// Something of it can't be read, or is not as it was written.
    bool is_damaged() const { return !fault.empty() || skipped.count > 0 || !mismatches.empty(); }
    /// "it was not ended: …", "damaged behind …", lines for people.
    std::vector<std::string> notes() const;
};

/// Item by item, of any format: how it begins tells. "-" is standard input. A file that is still written is read as far as it goes.
class RecordingInput {
public:
    /// Throws UsageError when it can't be read.
    RecordingInput(const std::string& path, Streams& streams);
    ~RecordingInput();
    RecordingInput(const RecordingInput&) = delete;
    RecordingInput& operator=(const RecordingInput&) = delete;

    /// Valid until the next call; nothing: there are no more. Throws Failure when it is no recording.
    std::optional<anogate::Recorded> next();
    /// Of that which was read.
    RecordingFacts facts() const;
    const anogate::RecordingHead& head() const noexcept { return reader_->head(); }

private:
    bool read();

    std::string path_;
    int fd_;
    std::vector<char> room_;
    std::unique_ptr<anogate::RecordingReader>
        reader_;    // by what was read first; until then there is one that was given nothing
    std::uint64_t size_ = 0;
};

/// What the index of a recording tells, where it has one and is a file that can be read anywhere; otherwise all of it has to be read.
struct IndexedRecording {
    RecordingFacts facts;
    anogate::RecordingCounts counts;
};
std::optional<IndexedRecording> read_index(const std::string& path);

/// Gives each item to `take`, with the head of the recording that it is of, and reads to the end.
using TakeRecorded = std::function<void(const anogate::Recorded& item, const anogate::RecordingHead& head)>;
RecordingFacts read_recording(const std::string& path, Streams& streams, const TakeRecorded& take);

}    // namespace anoctl
