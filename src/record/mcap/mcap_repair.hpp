// Repairs an MCAP file that was truncated. No I/O.
//
// Keeps the file up to the end of the last intact chunk; the indexes of that chunk and everything after it are written again. A
// complete recording that was truncated later gets the same bytes again. A damaged chunk stays if an intact one follows; no index
// refers to it.
#pragma once
#include <record/crc32.hpp>
#include <record/mcap/mcap_chunk.hpp>
#include <record/mcap/mcap_items.hpp>
#include <record/mcap/mcap_records.hpp>
#include <record/recording_counts.hpp>
#include <record/recording_repair.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

namespace mcap {

/// A chunk that is kept. It is added to the summary when the offsets of its indexes are known.
struct KeptChunk {
    ChunkPlace place;
    std::string compression;
    MessageIndexes indexes;
    IndexOffsets offsets;    // of the indexes after it
    std::uint64_t index_size = 0;
};

}    // namespace mcap

class McapRepair final : public RecordingRepair::Reading {
public:
    void feed(std::string_view bytes) override;
    RecordingRepair::Result finish() override;

private:
    void process(const mcap::Record& record);
    void process_chunk(const mcap::Record& record);
    void process_damaged(const mcap::Record& record, const mcap::ChunkFault& fault);
    void process_index(const mcap::Record& record);
    void process_inner(const mcap::Record& record, std::uint64_t offset);
    void add_last_chunk();
    void keep();
    std::string ending() const;

    mcap::Records records_;
    mcap::ChunkOpener opener_;
    mcap::Items items_;
    mcap::Summary summary_;
    RecordingCounts counts_;
    std::string chunk_;
    std::optional<mcap::KeptChunk> last_;
    std::uint64_t keep_ = 0;
    std::string ending_;    // the end of a file of ending_of_ bytes
    std::uint64_t ending_of_ = 0;
    Crc32 before_crc_, read_crc_, kept_crc_;    // up to before the last record, including it, and of the kept part
    bool is_ours_ = false, is_data_over_ = false;
};

}    // namespace anogate
