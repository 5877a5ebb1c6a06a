// Reads a recording of either format. No I/O.
//
// Flow:    const auto reader = make_recording_reader(first_piece);    // not empty
//          for (each piece of the file) { reader->give(piece); while (const auto item = reader->next()) ...; }
//          if (reader->is_damaged()) ...
//
// From a truncated file, everything complete before its end is returned. A damaged part is skipped and listed in skipped() if the
// beginning of the next part is known.
#pragma once
#include <record/recording_writer.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace anogate {

/// A damaged chunk of MCAP or block of pcapng that was skipped.
struct SkippedPart {
    std::uint64_t at = 0, size = 0;             // bytes of the file
    std::optional<std::uint64_t> messages{};    // in it, from the index after it or its type; std::nullopt: unknown
    std::string_view why;                       // a clause; valid as long as the program runs

    friend bool operator==(const SkippedPart&, const SkippedPart&) = default;
};

struct SkippedParts {
    static constexpr std::size_t max_listed = 16;

    std::uint64_t count = 0, bytes = 0;
    std::uint64_t frames = 0;            // known to be in the skipped parts
    std::vector<SkippedPart> first{};    // the first skipped parts, at most max_listed

    void add(const SkippedPart& part) {
        ++count;
        bytes += part.size;
        if (first.size() < max_listed) first.push_back(part);
    }
    friend bool operator==(const SkippedParts&, const SkippedParts&) = default;
};

class RecordingReader {
public:
    virtual ~RecordingReader() = default;

    /// The next bytes of the file.
    virtual void feed(std::string_view bytes) = 0;
    /// Valid until the next call. std::nullopt: more bytes are needed, or the file is damaged.
    virtual std::optional<Recorded> next() = 0;

    virtual RecordingFormat format() const noexcept = 0;
    /// Why nothing after position() can be read, in a clause; nullptr: not damaged.
    virtual const char* fault() const noexcept = 0;
    bool is_damaged() const noexcept { return fault() != nullptr; }
    /// Bytes of the file that were read.
    virtual std::uint64_t position() const noexcept = 0;
    /// The skipped parts before position().
    virtual SkippedParts skipped() const = 0;
    /// Checksums over parts of the file that do not match although nothing was skipped there, as clauses; valid as long as the
    /// program runs. The returned frames are correct if their own checksums are.
    virtual std::vector<std::string_view> mismatches() const { return {}; }
    /// Bytes after position(): the beginning of an incomplete part.
    virtual std::size_t unfinished() const noexcept = 0;

    virtual const RecordingHead& head() const noexcept = 0;
    /// Whether the end mark of the recording was read after the last frame.
    virtual bool has_end() const noexcept = 0;
    /// Number of packets that are not complete frames: of another program, or damaged.
    virtual std::uint64_t foreign() const noexcept = 0;
    /// Whether the file has the right format but no data of anogate: another program wrote it.
    virtual bool is_strange() const noexcept = 0;
};

/// `begin`: the first bytes of the file, which identify the format.
std::unique_ptr<RecordingReader> make_recording_reader(std::string_view begin);

}    // namespace anogate
