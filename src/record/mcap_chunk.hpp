// The chunks of an MCAP file, as they are made and as they are read. No I/O.
#pragma once
#include <record/mcap_summary.hpp>
#include <record/zstd.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::mcap {

/// Which messages a chunk has, and where in it.
class MessageIndexes {
public:
    /// `offset`: of the record, in the unpacked chunk.
    void add(std::uint16_t channel, std::uint64_t log_time, std::uint64_t offset);
    bool is_empty() const noexcept { return used_.empty(); }
    std::uint64_t first_time() const noexcept { return first_time_; }
    std::uint64_t last_time() const noexcept { return last_time_; }

    /// Appends a MessageIndex for each channel, to a file of `at` bytes, and says where each is; then it is empty.
    IndexOffsets append(std::string& out, std::uint64_t at);
    void clear();

private:
    struct Entry {
        std::uint64_t log_time, offset;
    };
    std::vector<std::vector<Entry>> entries_;    // by channel; they keep their memory
    std::vector<std::uint16_t> used_;
    std::uint64_t first_time_ = 0, last_time_ = 0;
};

/// A chunk that grows.
class ChunkBuilder {
public:
    explicit ChunkBuilder(bool packed) : packed_{packed} {}

    std::size_t size() const noexcept { return records_.size(); }
    /// A Schema or a Channel, whole.
    void add_record(std::string_view record) { records_ += record; }
    void add_message(const Message& message);
    /// Appends it with its indexes to a file of `at` bytes, tells the summary, and is empty then; of an empty one nothing.
    void end(std::string& out, std::uint64_t at, Summary& summary);

private:
    bool packed_;
    std::string records_;
    MessageIndexes indexes_;
    ZstdPacker packer_;
};

/// A chunk that was read. Its texts are in the memory of the record.
struct ChunkRecord {
    std::uint64_t first_time = 0, last_time = 0;
    std::uint64_t unpacked_size = 0;
    std::uint32_t unpacked_crc = 0;
    std::string_view compression, records;
};
std::optional<ChunkRecord> chunk_of(std::string_view body) noexcept;

/// What is wrong with a chunk.
struct ChunkFault {
    const char* why = nullptr;    // in a clause; nullptr: nothing is
    bool is_damage = true;        // of this one; false: no chunk like it is read
};

/// Takes chunks apart.
class ChunkOpener {
public:
    /// Makes `records` of the body of its record, all of them whole.
    ChunkFault open(std::string_view body, std::string& records);
    ChunkFault open(const ChunkRecord& chunk, std::string& records);

private:
    ZstdUnpacker unpacker_;
};

}    // namespace anogate::mcap
