#include <record/crc32.hpp>
#include <record/mcap/mcap_summary.hpp>

#include <algorithm>
#include <utility>
#include <vector>

namespace anogate::mcap {
namespace {

std::uint16_t id_of(std::string_view record) { return Fields{record.substr(record_head)}.number<std::uint16_t>(); }

// Groups of records of one kind, with their offsets.
class Groups {
public:
    Groups(std::string& out, std::uint64_t at) : out_{out}, begin_{out.size()}, at_{at} {}

    std::uint64_t position() const { return at_ + (out_.size() - begin_); }
    template <class Put>
    void add(Opcode opcode, Put put_records) {
        const std::uint64_t from = position();
        put_records(out_);
        if (position() > from) groups_.push_back({opcode, from, position() - from});
    }
    void append_offsets() {
        for (const Group& group : groups_) {
            const std::size_t begun = begin_record(out_, Opcode::summary_offset);
            append_le(out_, static_cast<std::uint8_t>(group.opcode));
            append_le(out_, group.at);
            append_le(out_, group.size);
            end_record(out_, begun);
        }
    }

private:
    struct Group {
        Opcode opcode;
        std::uint64_t at, size;
    };
    std::string& out_;
    std::size_t begin_;
    std::uint64_t at_;
    std::vector<Group> groups_;
};

template <class T>
void append_map(std::string& out, const std::map<std::uint16_t, T>& map) {
    append_le(out, static_cast<std::uint32_t>(map.size() * (sizeof(std::uint16_t) + sizeof(T))));
    for (const auto& [key, value] : map) {
        append_le(out, key);
        append_le(out, value);
    }
}

}    // namespace

void Summary::add_schema(std::string_view record) { schemas_.try_emplace(id_of(record), record); }
void Summary::add_channel(std::string_view record) { channels_.try_emplace(id_of(record), record); }

void Summary::add_message(std::uint16_t channel, std::uint64_t log_time) {
    first_time_ = message_count_ == 0 ? log_time : std::min(first_time_, log_time);
    last_time_ = std::max(last_time_, log_time);
    ++message_count_;
    ++messages_[channel];
}

void Summary::add_chunk(const ChunkPlace& chunk, const IndexOffsets& offsets, std::uint64_t index_size) {
    const std::size_t begun = begin_record(chunks_, Opcode::chunk_index);
    append_le(chunks_, chunk.first_time);
    append_le(chunks_, chunk.last_time);
    append_le(chunks_, chunk.at);
    append_le(chunks_, chunk.size);
    append_map(chunks_, offsets);
    append_le(chunks_, index_size);
    append_string(chunks_, chunk.compression);
    append_le(chunks_, chunk.packed);
    append_le(chunks_, chunk.unpacked);
    end_record(chunks_, begun);
    ++chunk_count_;
}

void Summary::add_metadata(std::string_view record, std::uint64_t at) {
    const std::size_t begun = begin_record(metadata_, Opcode::metadata_index);
    append_le(metadata_, at);
    append_le(metadata_, static_cast<std::uint64_t>(record.size()));
    append_string(metadata_, name_of_metadata(record.substr(record_head)));
    end_record(metadata_, begun);
    ++metadata_count_;
}

void Summary::append_statistics(std::string& out) const {
    const std::size_t begun = begin_record(out, Opcode::statistics);
    append_le(out, message_count_);
    append_le(out, static_cast<std::uint16_t>(schemas_.size()));
    append_le(out, static_cast<std::uint32_t>(channels_.size()));
    append_le(out, std::uint32_t{0});    // attachments
    append_le(out, metadata_count_);
    append_le(out, chunk_count_);
    append_le(out, first_time_);
    append_le(out, last_time_);
    append_map(out, messages_);
    end_record(out, begun);
}

void Summary::append(std::string& out, std::uint64_t at, std::uint32_t data_crc) const {
    const std::size_t before = out.size();
    const std::size_t data_end = begin_record(out, Opcode::data_end);
    append_le(out, data_crc);
    end_record(out, data_end);

    const std::size_t begin = out.size();
    const std::uint64_t summary_start = at + (begin - before);
    Groups groups{out, summary_start};
    const auto all = [](const auto& records) {
        return [&records](std::string& to) {
            for (const auto& [id, record] : records) to += record;
        };
    };
    groups.add(Opcode::schema, all(schemas_));
    groups.add(Opcode::channel, all(channels_));
    groups.add(Opcode::statistics, [this](std::string& to) { append_statistics(to); });
    groups.add(Opcode::chunk_index, [this](std::string& to) { to += chunks_; });
    groups.add(Opcode::metadata_index, [this](std::string& to) { to += metadata_; });
    const std::uint64_t offsets_start = groups.position();
    groups.append_offsets();

    const std::size_t footer = begin_record(out, Opcode::footer);
    append_le(out, summary_start);
    append_le(out, offsets_start);
    ano::store(reinterpret_cast<std::uint8_t*>(out.data()) + footer - 8,
               std::uint64_t{footer_size - record_head});    // set before the CRC, which covers it
    append_le(out, crc32_of(std::string_view{out}.substr(begin)));
    out += magic;
}

}    // namespace anogate::mcap
