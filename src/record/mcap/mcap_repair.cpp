#include <record/mcap/mcap_repair.hpp>

#include <utility>

namespace anogate {

void McapRepair::feed(std::string_view bytes) {
    records_.feed(bytes);
    while (const auto record = records_.next()) {
        if (records_.position() == mcap::magic.size() + record->whole.size()) read_crc_.add(mcap::magic);
        before_crc_ = read_crc_;
        read_crc_.add(record->whole);
        if (!is_data_over_) process(*record);
    }
}

void McapRepair::process(const mcap::Record& record) {
    switch (record.opcode) {
    case mcap::Opcode::chunk: process_chunk(record); break;
    case mcap::Opcode::message_index: process_index(record); break;
    case mcap::Opcode::metadata: {
        const std::string_view name = mcap::name_of_metadata(record.body);
        if (name == mcap::counts_name) break;    // written again at the end
        if (name == mcap::head_name) is_ours_ = true;
        add_last_chunk();
        summary_.add_metadata(record.whole, records_.position() - record.whole.size());
        keep();
        break;
    }
    case mcap::Opcode::schema:
    case mcap::Opcode::channel:
    case mcap::Opcode::message:
        add_last_chunk();
        process_inner(record, 0);
        keep();
        break;
    case mcap::Opcode::data_end:
    case mcap::Opcode::footer: is_data_over_ = true; break;
    default: break;
    }
}

void McapRepair::keep() {
    keep_ = records_.position();
    kept_crc_ = read_crc_;
}

void McapRepair::process_chunk(const mcap::Record& record) {
    const mcap::ChunkFault fault = opener_.open(record.body, chunk_);
    if (fault.why != nullptr) return process_damaged(record, fault);
    const auto chunk = mcap::chunk_of(record.body);
    add_last_chunk();
    last_.emplace();
    last_->compression = chunk->compression;
    last_->place = {chunk->first_time,   chunk->last_time,   records_.position() - record.whole.size(),
                    record.whole.size(), last_->compression, chunk->records.size(),
                    chunk_.size()};
    std::string_view rest = chunk_;
    while (const auto inner = mcap::next_record(rest)) process_inner(*inner, chunk_.size() - rest.size() - inner->whole.size());
    keep();
}

// Keeps everything before the damaged chunk, with indexes. Keeps the chunk itself only if an intact one follows.
void McapRepair::process_damaged(const mcap::Record& record, const mcap::ChunkFault& fault) {
    if (!fault.is_damage) return records_.refuse(fault.why, record);
    items_.miss_channels();
    if (!last_) return;
    add_last_chunk();
    keep_ = records_.position() - record.whole.size();
    kept_crc_ = before_crc_;
}

// Also called for a record outside any chunk: it is counted, but is not indexed.
void McapRepair::process_inner(const mcap::Record& record, std::uint64_t offset) {
    constexpr std::size_t id_size = 2;
    if (record.body.size() < id_size) return;
    if (record.opcode == mcap::Opcode::schema) summary_.add_schema(record.whole);
    if (record.opcode == mcap::Opcode::channel) {
        summary_.add_channel(record.whole);
        items_.add_channel(record.body);
    }
    if (record.opcode != mcap::Opcode::message) return;
    const auto message = mcap::message_of(record.body);
    if (!message) return;
    summary_.add_message(message->channel, message->log_time);
    if (last_) last_->indexes.add(message->channel, message->log_time, offset);
    if (const auto item = items_.item_of(*message)) counts_.add(*item);
}

void McapRepair::process_index(const mcap::Record& record) {
    if (!last_) return;
    last_->offsets[mcap::Fields{record.body}.number<std::uint16_t>()] = records_.position() - record.whole.size();
    last_->index_size += record.whole.size();
}

// Adds the last chunk with the offsets of its indexes to the summary.
void McapRepair::add_last_chunk() {
    if (!last_) return;
    last_->place.compression = last_->compression;
    summary_.add_chunk(last_->place, last_->offsets, last_->index_size);
    last_.reset();
}

// The bytes to be appended to the kept part.
std::string McapRepair::ending() const {
    std::string ending;
    mcap::Summary summary = summary_;
    if (last_) {    // its indexes may be incomplete
        mcap::MessageIndexes indexes = last_->indexes;
        mcap::ChunkPlace place = last_->place;
        place.compression = last_->compression;
        const mcap::IndexOffsets offsets = indexes.append(ending, keep_);
        summary.add_chunk(place, offsets, ending.size());
    }
    std::string metadata;
    mcap::append_metadata(metadata, mcap::counts_name, {{"json", counts_.json()}});
    summary.add_metadata(metadata, keep_ + ending.size());
    ending += metadata;
    Crc32 crc = kept_crc_;
    crc.add(ending);
    summary.append(ending, keep_ + ending.size(), crc.value());
    return ending;
}

RecordingRepair::Result McapRepair::finish() {
    RecordingRepair::Result result;
    result.frames = counts_.frames;
    result.is_recording = is_ours_;
    result.is_whole = is_ours_ && records_.is_ended() && records_.fault() == nullptr;
    result.keep = result.is_whole || !is_ours_ ? records_.position() : keep_;
    if (result.is_whole || !is_ours_) return result;
    if (ending_of_ != keep_) {
        ending_ = ending();
        ending_of_ = keep_;
    }
    result.append = ending_;
    return result;
}

}    // namespace anogate
