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
    void put_offsets() {
        for (const Group& group : groups_) {
            const std::size_t begun = begin_record(out_, Opcode::summary_offset);
            put(out_, static_cast<std::uint8_t>(group.opcode));
            put(out_, group.at);
            put(out_, group.size);
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
void put_map(std::string& out, const std::map<std::uint16_t, T>& map) {
    put(out, static_cast<std::uint32_t>(map.size() * (sizeof(std::uint16_t) + sizeof(T))));
    for (const auto& [key, value] : map) {
        put(out, key);
        put(out, value);
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
    put(chunks_, chunk.first_time);
    put(chunks_, chunk.last_time);
    put(chunks_, chunk.at);
    put(chunks_, chunk.size);
    put_map(chunks_, offsets);
    put(chunks_, index_size);
    put_text(chunks_, chunk.compression);
    put(chunks_, chunk.packed);
    put(chunks_, chunk.unpacked);
    end_record(chunks_, begun);
    ++chunk_count_;
}

void Summary::add_metadata(std::string_view record, std::uint64_t at) {
    const std::size_t begun = begin_record(metadata_, Opcode::metadata_index);
    put(metadata_, at);
    put(metadata_, static_cast<std::uint64_t>(record.size()));
    put_text(metadata_, name_of_metadata(record.substr(record_head)));
    end_record(metadata_, begun);
    ++metadata_count_;
}

void Summary::put_statistics(std::string& out) const {
    const std::size_t begun = begin_record(out, Opcode::statistics);
    put(out, message_count_);
    put(out, static_cast<std::uint16_t>(schemas_.size()));
    put(out, static_cast<std::uint32_t>(channels_.size()));
    put(out, std::uint32_t{0});    // attachments
    put(out, metadata_count_);
    put(out, chunk_count_);
    put(out, first_time_);
    put(out, last_time_);
    put_map(out, messages_);
    end_record(out, begun);
}

void Summary::append(std::string& out, std::uint64_t at, std::uint32_t data_crc) const {
    const std::size_t before = out.size();
    const std::size_t data_end = begin_record(out, Opcode::data_end);
    put(out, data_crc);
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
    groups.add(Opcode::statistics, [this](std::string& to) { put_statistics(to); });
    groups.add(Opcode::chunk_index, [this](std::string& to) { to += chunks_; });
    groups.add(Opcode::metadata_index, [this](std::string& to) { to += metadata_; });
    const std::uint64_t offsets_start = groups.position();
    groups.put_offsets();

    const std::size_t footer = begin_record(out, Opcode::footer);
    put(out, summary_start);
    put(out, offsets_start);
    ano::store(reinterpret_cast<std::uint8_t*>(out.data()) + footer - 8,
               std::uint64_t{footer_size - record_head});    // set before the CRC, which covers it
    put(out, crc32_of(std::string_view{out}.substr(begin)));
    out += magic;
}

}    // namespace anogate::mcap
