#include <record/crc32.hpp>
#include <record/mcap/mcap_chunk.hpp>

#include <algorithm>

namespace anogate::mcap {

void MessageIndexes::add(std::uint16_t channel, std::uint64_t log_time, std::uint64_t offset) {
    if (channel >= entries_.size()) entries_.resize(std::size_t{channel} + 1);
    if (entries_[channel].empty()) {
        const bool is_first = used_.empty();
        used_.push_back(channel);
        if (is_first) first_time_ = last_time_ = log_time;
    }
    entries_[channel].push_back({log_time, offset});
    first_time_ = std::min(first_time_, log_time);    // not the first message if the clock was set back
    last_time_ = std::max(last_time_, log_time);
}

IndexOffsets MessageIndexes::append(std::string& out, std::uint64_t at) {
    IndexOffsets offsets;
    const std::size_t before = out.size();
    std::sort(used_.begin(), used_.end());
    for (const std::uint16_t channel : used_) {
        offsets[channel] = at + (out.size() - before);
        const std::size_t begun = begin_record(out, Opcode::message_index);
        append_le(out, channel);
        append_le(out, static_cast<std::uint32_t>(entries_[channel].size() * sizeof(Entry)));
        for (const Entry& entry : entries_[channel]) {
            append_le(out, entry.log_time);
            append_le(out, entry.offset);
        }
        end_record(out, begun);
    }
    clear();
    return offsets;
}

void MessageIndexes::clear() {
    for (const std::uint16_t channel : used_) entries_[channel].clear();
    used_.clear();
    first_time_ = last_time_ = 0;
}

void ChunkBuilder::add_message(const Message& message) {
    indexes_.add(message.channel, message.log_time, records_.size());
    append_message(records_, message);
}

void ChunkBuilder::end(std::string& out, std::uint64_t at, Summary& summary) {
    if (records_.empty()) return;
    ChunkPlace place;
    place.first_time = indexes_.first_time();
    place.last_time = indexes_.last_time();
    place.at = at;
    place.compression = packed_ ? "zstd" : "";
    place.unpacked = records_.size();

    const std::size_t begun = begin_record(out, Opcode::chunk);
    append_le(out, place.first_time);
    append_le(out, place.last_time);
    append_le(out, place.unpacked);
    append_le(out, crc32_of(records_));
    append_string(out, place.compression);
    const std::size_t packed_at = out.size() + sizeof(std::uint64_t);
    append_le(out, std::uint64_t{0});
    if (packed_) packer_.pack(records_, out);
    else out += records_;
    place.packed = out.size() - packed_at;
    ano::store(reinterpret_cast<std::uint8_t*>(out.data()) + packed_at - sizeof(std::uint64_t), place.packed);
    end_record(out, begun);
    place.size = out.size() - begun + record_head;

    const std::size_t indexes_at = out.size();
    const IndexOffsets offsets = indexes_.append(out, at + place.size);
    summary.add_chunk(place, offsets, out.size() - indexes_at);
    records_.clear();
}

std::optional<ChunkRecord> chunk_of(std::string_view body) noexcept {
    Fields fields{body};
    ChunkRecord chunk;
    chunk.first_time = fields.number<std::uint64_t>();
    chunk.last_time = fields.number<std::uint64_t>();
    chunk.unpacked_size = fields.number<std::uint64_t>();
    chunk.unpacked_crc = fields.number<std::uint32_t>();
    chunk.compression = fields.text();
    chunk.records = fields.bytes(fields.number<std::uint64_t>());
    return fields.is_bad() ? std::nullopt : std::optional{chunk};
}

ChunkFault ChunkOpener::open(std::string_view body, std::string& records) {
    const auto chunk = chunk_of(body);
    return chunk ? open(*chunk, records) : ChunkFault{"it is shorter than its header states"};
}

ChunkFault ChunkOpener::open(const ChunkRecord& chunk, std::string& records) {
    if (chunk.unpacked_size > max_chunk) return {"it is longer than 64 MiB"};
    if (chunk.compression == "zstd") {
        if (!unpacker_.unpack(chunk.records, static_cast<std::size_t>(chunk.unpacked_size), records))
            return {"it can't be decompressed"};
    } else if (chunk.compression.empty()) {
        if (chunk.records.size() != chunk.unpacked_size) return {"its length is not the length in its header"};
        records = chunk.records;
    } else if (chunk.compression == "lz4") {
        return {"its chunks are compressed with lz4, which is not supported: convert it with `mcap compress --compression zstd`",
                false};
    } else {
        return {"its chunks use an unknown compression", false};
    }
    if (chunk.unpacked_crc != 0 && crc32_of(records) != chunk.unpacked_crc) return {"its checksum is wrong"};
    std::string_view rest = records;
    while (next_record(rest)) continue;
    return {rest.empty() ? nullptr : "a record in it extends beyond its end"};
}

}    // namespace anogate::mcap
