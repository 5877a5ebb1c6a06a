#include <record/mcap_reader.hpp>

#include <charconv>
#include <utility>

namespace anogate {
namespace {

std::uint64_t number_of(std::string_view text) {
    std::uint64_t number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

}    // namespace

RecordingHead mcap::recording_head_of(std::string_view metadata) {
    return {std::string{metadata_at(metadata, "program")}, number_of(metadata_at(metadata, "time_ns")),
            number_of(metadata_at(metadata, "boottime_ns"))};
}

void McapReader::give(std::string_view bytes) {
    item_.reset();
    records_.give(bytes);
}

std::optional<Recorded> McapReader::next() {
    while (true) {
        if (item_) return std::exchange(item_, std::nullopt);
        if (const auto record = mcap::take_record(rest_)) take(*record);
        else if (const auto outer = records_.next()) take_outer(*outer);
        else return std::nullopt;
    }
}

// What a chunk may have in it.
void McapReader::take(const mcap::Record& record) {
    if (record.opcode == mcap::Opcode::channel) items_.add_channel(record.body);
    if (record.opcode != mcap::Opcode::message) return;
    if (const auto message = mcap::message_of(record.body)) item_ = items_.item_of(*message);
}

void McapReader::take_outer(const mcap::Record& record) {
    if (is_data_over_) return;    // the summary repeats what was read
    switch (record.opcode) {
    case mcap::Opcode::chunk: {
        const auto chunk = mcap::chunk_of(record.body);
        const char* const fault = chunk ? opener_.open(*chunk, chunk_) : "a chunk is shorter than what it tells of itself";
        if (fault != nullptr) return records_.refuse(fault, record);
        rest_ = chunk_;
        break;
    }
    case mcap::Opcode::metadata:
        if (mcap::name_of_metadata(record.body) != mcap::head_name) break;
        head_ = mcap::recording_head_of(record.body);
        has_head_ = true;
        break;
    case mcap::Opcode::data_end:
    case mcap::Opcode::footer: is_data_over_ = true; break;
    default: take(record);
    }
}

bool McapReader::is_strange() const noexcept {
    return records_.position() > mcap::magic.size() && !has_head_ && !items_.has_channel();
}

}    // namespace anogate
