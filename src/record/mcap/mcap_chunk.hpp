// Writes and reads the chunks of an MCAP file. No I/O.
#pragma once
#include <record/mcap/mcap_summary.hpp>
#include <record/zstd.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::mcap {

/// Collects the offsets of the messages of a chunk.
class MessageIndexes {
public:
    /// `offset`: of the record in the uncompressed chunk.
    void add(std::uint16_t channel, std::uint64_t log_time, std::uint64_t offset);
    bool is_empty() const noexcept { return used_.empty(); }
    std::uint64_t first_time() const noexcept { return first_time_; }
    std::uint64_t last_time() const noexcept { return last_time_; }

    /// Appends a MessageIndex for each channel to a file of `at` bytes and returns the offset of each. Empty afterwards.
    IndexOffsets append(std::string& out, std::uint64_t at);
    void clear();

private:
    struct Entry {
        std::uint64_t log_time, offset;
    };
    std::vector<std::vector<Entry>> entries_;    // by channel; not freed, to reuse the memory
    std::vector<std::uint16_t> used_;
    std::uint64_t first_time_ = 0, last_time_ = 0;
};

/// A chunk that is being written.
class ChunkBuilder {
public:
    explicit ChunkBuilder(bool packed) : packed_{packed} {}

    std::size_t size() const noexcept { return records_.size(); }
    /// A complete Schema or Channel record.
    void add_record(std::string_view record) { records_ += record; }
    void add_message(const Message& message);
    /// Appends the chunk with its indexes to a file of `at` bytes and adds it to `summary`. Empty afterwards. Does nothing if it is empty.
    void end(std::string& out, std::uint64_t at, Summary& summary);

private:
    bool packed_;
    std::string records_;
    MessageIndexes indexes_;
    ZstdPacker packer_;
};

/// A parsed chunk. Its texts refer to the record.
struct ChunkRecord {
    std::uint64_t first_time = 0, last_time = 0;
    std::uint64_t unpacked_size = 0;
    std::uint32_t unpacked_crc = 0;
    std::string_view compression, records;
};
std::optional<ChunkRecord> chunk_of(std::string_view body) noexcept;

/// Why a chunk can't be read.
struct ChunkFault {
    const char* why = nullptr;    // a clause; nullptr: no fault
    bool is_damage = true;        // false: the chunk is intact, but its kind is not supported
};

/// Decompresses and checks chunks.
class ChunkOpener {
public:
    /// Sets `records` to the records of the chunk; all of them are complete.
    ChunkFault open(std::string_view body, std::string& records);
    ChunkFault open(const ChunkRecord& chunk, std::string& records);

private:
    ZstdUnpacker unpacker_;
};

}    // namespace anogate::mcap
