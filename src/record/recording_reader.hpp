// Reads a recording in one format or another. No I/O.
//
// Flow:    const auto reader = make_recording_reader(first_piece);    // which may be all there is yet, but not nothing
//          for (each piece of the file) { reader->give(piece); while (const auto item = reader->next()) ...; }
//          if (reader->is_damaged()) ...
//
// Of a file that was cut, all that is whole before the cut is given. A part whose damage does not hide where the next one begins is left
// out, and told in skipped().
#pragma once
#include <record/recording_writer.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace anogate {

/// A chunk of MCAP or a block of pcapng that is damaged and was left out.
struct SkippedPart {
    std::uint64_t at = 0, size = 0;             // bytes of the file
    std::optional<std::uint64_t> messages{};    // that it has, as the index behind it or its kind tells; nothing: none does
    std::string_view why;                       // in a clause; lives as long as the program

    friend bool operator==(const SkippedPart&, const SkippedPart&) = default;
};

struct SkippedParts {
    static constexpr std::size_t max_told = 16;

    std::uint64_t count = 0, bytes = 0;
    std::uint64_t frames = 0;            // of which it is known that they were in there
    std::vector<SkippedPart> first{};    // of them, max_told at most

    void add(const SkippedPart& part) {
        ++count;
        bytes += part.size;
        if (first.size() < max_told) first.push_back(part);
    }
    friend bool operator==(const SkippedParts&, const SkippedParts&) = default;
};

class RecordingReader {
public:
    virtual ~RecordingReader() = default;

    /// The next bytes of the file.
    virtual void give(std::string_view bytes) = 0;
    /// Nothing: all that is whole was given, or the file is damaged. Valid until the next call.
    virtual std::optional<Recorded> next() = 0;

    virtual RecordingFormat format() const noexcept = 0;
    /// In a clause, why nothing more is read behind position(); nullptr: it is not damaged.
    virtual const char* fault() const noexcept = 0;
    bool is_damaged() const noexcept { return fault() != nullptr; }
    /// How many bytes of the file were understood.
    virtual std::uint64_t position() const noexcept = 0;
    /// What before position() was left out.
    virtual SkippedParts skipped() const = 0;
    /// In clauses, which checksums over parts of the file do not match, where nothing that was left out explains it; they live as
    /// long as the program. What was given is right where its own checksums are.
    virtual std::vector<std::string_view> mismatches() const { return {}; }
    /// Bytes behind position(): the begin of something whose end is not there.
    virtual std::size_t unfinished() const noexcept = 0;

    virtual const RecordingHead& head() const noexcept = 0;
    /// What tells that the recording was ended came behind the last frame.
    virtual bool has_end() const noexcept = 0;
    /// Packets that are no whole frame: of another program, or damaged.
    virtual std::uint64_t foreign() const noexcept = 0;
    /// It is of the format, but nothing in it tells of frames: another program wrote it.
    virtual bool is_strange() const noexcept = 0;
};

/// By how the file begins.
std::unique_ptr<RecordingReader> make_recording_reader(std::string_view begin);

}    // namespace anogate
