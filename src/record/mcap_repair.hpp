// Makes an MCAP file that was cut a whole one again. No I/O.
//
// What is whole is kept as it is, to the end of the last chunk; its indexes and everything behind are made anew. Of a recording that was
// ended, and then cut, that gives the same bytes again. A damaged chunk stays where a good one comes behind it, and no index leads there.
#pragma once
#include <record/crc32.hpp>
#include <record/mcap_chunk.hpp>
#include <record/mcap_items.hpp>
#include <record/mcap_records.hpp>
#include <record/recording_counts.hpp>
#include <record/recording_repair.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

namespace mcap {

/// A chunk that is kept. Its indexes are told to the summary when it is known where they are.
struct KeptChunk {
    ChunkPlace place;
    std::string compression;
    MessageIndexes indexes;
    IndexOffsets offsets;    // of those that stand behind it
    std::uint64_t index_size = 0;
};

}    // namespace mcap

class McapRepair final : public RecordingRepair::Reading {
public:
    void give(std::string_view bytes) override;
    RecordingRepair::Result finish() override;

private:
    void take(const mcap::Record& record);
    void take_chunk(const mcap::Record& record);
    void take_damaged(const mcap::Record& record, const mcap::ChunkFault& fault);
    void take_index(const mcap::Record& record);
    void take_inner(const mcap::Record& record, std::uint64_t offset);
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
    std::string ending_;    // of the file that ends behind ending_of_ bytes
    std::uint64_t ending_of_ = 0;
    Crc32 before_crc_, read_crc_, kept_crc_;    // before the last record, behind it, and of what is kept
    bool is_ours_ = false, is_data_over_ = false;
};

}    // namespace anogate
