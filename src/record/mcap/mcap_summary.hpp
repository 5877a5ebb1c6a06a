// The summary after the data of an MCAP file: programs find everything by it without reading the whole file. No I/O.
#pragma once
#include <record/mcap/mcap_format.hpp>

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace anogate::mcap {

/// Channel → offset of its MessageIndex in the file.
using IndexOffsets = std::map<std::uint16_t, std::uint64_t>;

/// A chunk in the file.
struct ChunkPlace {
    std::uint64_t first_time = 0, last_time = 0;    // earliest and latest log_time, ns
    std::uint64_t at = 0, size = 0;                 // of the record, including its head
    std::string_view compression;
    std::uint64_t packed = 0, unpacked = 0;    // bytes of its records, compressed and uncompressed
};

/// Uses about 100 bytes of memory for each chunk, and 10 for each channel of it.
class Summary {
public:
    /// Complete records. For each id only the first one is used.
    void add_schema(std::string_view record);
    void add_channel(std::string_view record);
    void add_message(std::uint16_t channel, std::uint64_t log_time);
    /// `index_size`: bytes of the MessageIndex records after the chunk.
    void add_chunk(const ChunkPlace& chunk, const IndexOffsets& offsets, std::uint64_t index_size);
    /// A complete record at offset `at` of the file.
    void add_metadata(std::string_view record, std::uint64_t at);

    /// Appends everything from DataEnd to the last magic to a file of `at` bytes with the CRC `data_crc`.
    void append(std::string& out, std::uint64_t at, std::uint32_t data_crc) const;

private:
    void append_statistics(std::string& out) const;

    std::map<std::uint16_t, std::string> schemas_, channels_;    // complete records
    std::string chunks_, metadata_;                              // ChunkIndex and MetadataIndex records
    std::map<std::uint16_t, std::uint64_t> messages_;            // by channel
    std::uint64_t first_time_ = 0, last_time_ = 0, message_count_ = 0;
    std::uint32_t chunk_count_ = 0, metadata_count_ = 0;
};

}    // namespace anogate::mcap
