// Reads the frames of an MCAP file, no matter which program wrote it. No I/O.
//
// Frames are returned in the order of the file; indexes are ignored. Memory is bounded by the largest record of the file and the
// largest chunk, mcap::max_chunk.
#pragma once
#include <record/crc32.hpp>
#include <record/mcap/mcap_chunk.hpp>
#include <record/mcap/mcap_items.hpp>
#include <record/mcap/mcap_records.hpp>
#include <record/recording_reader.hpp>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

namespace mcap {
/// Reads the Metadata mcap::head_name.
RecordingHead recording_head_of(std::string_view metadata);
}    // namespace mcap

class McapReader final : public RecordingReader {
public:
    void feed(std::string_view bytes) override;
    std::optional<Recorded> next() override;

    RecordingFormat format() const noexcept override { return RecordingFormat::mcap; }
    const char* fault() const noexcept override { return records_.fault(); }
    SkippedParts skipped() const override;
    /// CRCs of DataEnd and Footer that do not match. A CRC of 0 is not checked.
    std::vector<std::string_view> mismatches() const override { return mismatches_; }
    std::uint64_t position() const noexcept override { return records_.position(); }
    std::size_t unfinished() const noexcept override { return records_.unfinished(); }

    const RecordingHead& head() const noexcept override { return head_; }
    bool has_end() const noexcept override { return records_.is_ended(); }
    std::uint64_t foreign() const noexcept override { return items_.foreign(); }
    bool is_strange() const noexcept override;

private:
    void process(const mcap::Record& record);
    void process_outer(const mcap::Record& record);
    void process_metadata(std::string_view body);
    void process_chunk(const mcap::Record& record);
    void process_skipped_index(const mcap::Record& record);
    void check(const mcap::Record& record);

    mcap::Records records_;
    mcap::ChunkOpener opener_;
    mcap::Items items_;
    RecordingHead head_;
    bool has_head_ = false, is_data_over_ = false;
    std::string chunk_;               // the records of the current chunk
    std::string_view rest_;           // the unread part of chunk_
    std::optional<Recorded> item_;    // from the last record
    SkippedParts skipped_;
    Crc32 crc_;    // of the data so far; after DataEnd, of the summary
    std::vector<std::string_view> mismatches_;
    bool is_behind_skipped_ = false;                               // the next indexes belong to the last skipped chunk
    std::map<std::uint16_t, std::uint64_t> skipped_by_channel_;    // numbers of messages from those indexes
};

}    // namespace anogate
