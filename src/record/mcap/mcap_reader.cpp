#include <record/mcap/mcap_reader.hpp>

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
            number_of(metadata_at(metadata, "boottime_ns")), nullptr};
}

void McapReader::feed(std::string_view bytes) {
    item_.reset();
    records_.feed(bytes);
}

std::optional<Recorded> McapReader::next() {
    while (true) {
        if (item_) return std::exchange(item_, std::nullopt);
        if (const auto record = mcap::next_record(rest_)) process(*record);
        else if (const auto outer = records_.next()) process_outer(*outer);
        else return std::nullopt;
    }
}

// Records that may be inside a chunk.
void McapReader::process(const mcap::Record& record) {
    if (record.opcode == mcap::Opcode::channel) items_.add_channel(record.body);
    if (record.opcode != mcap::Opcode::message) return;
    if (const auto message = mcap::message_of(record.body)) item_ = items_.item_of(*message);
}

// The CRC of the data covers everything before DataEnd, including the first magic. The CRC of the summary ends with the fields of
// Footer before the CRC itself.
void McapReader::check(const mcap::Record& record) {
    using mcap::Opcode;
    if (records_.position() == mcap::magic.size() + record.whole.size()) crc_.add(mcap::magic);
    const bool is_end = record.opcode == Opcode::data_end, is_footer = record.opcode == Opcode::footer;
    if (!is_end && !is_footer) return crc_.add(record.whole);
    mcap::Fields fields{record.body};
    if (is_footer) {
        const std::size_t in_front = 2 * sizeof(std::uint64_t);    // offsets of the summary and of its SummaryOffset records
        fields.bytes(in_front);
        crc_.add(record.whole.substr(0, mcap::record_head + in_front));
    }
    const auto stored_crc = fields.number<std::uint32_t>();
    const bool is_known = is_end ? skipped_.count > 0 : !is_data_over_;
    if (stored_crc != 0 && stored_crc != crc_.value() && !is_known)
        mismatches_.push_back(is_end ? "the data does not match the CRC in its DataEnd"
                                     : "its summary does not match the CRC in its Footer");
    crc_ = {};
}

void McapReader::process_outer(const mcap::Record& record) {
    check(record);
    if (is_data_over_) {    // the summary repeats records of the data, also of skipped chunks
        if (skipped_.count > 0 && record.opcode == mcap::Opcode::channel) items_.add_channel(record.body);
        return;
    }
    if (is_behind_skipped_ && record.opcode == mcap::Opcode::message_index) return process_skipped_index(record);
    is_behind_skipped_ = false;
    switch (record.opcode) {
    case mcap::Opcode::chunk: process_chunk(record); break;
    case mcap::Opcode::metadata: process_metadata(record.body); break;
    case mcap::Opcode::data_end:
    case mcap::Opcode::footer: is_data_over_ = true; break;
    default: process(record);
    }
}

void McapReader::process_metadata(std::string_view body) {
    const std::string_view name = mcap::name_of_metadata(body);
    if (name == mcap::decoding_name) head_.use_decoding(mcap::metadata_at(body, "json"));
    if (name != mcap::head_name) return;
    head_ = mcap::recording_head_of(body);
    has_head_ = true;
}

void McapReader::process_chunk(const mcap::Record& record) {
    const mcap::ChunkFault fault = opener_.open(record.body, chunk_);
    if (fault.why == nullptr) {
        rest_ = chunk_;
        return;
    }
    if (!fault.is_damage) return records_.refuse(fault.why, record);
    skipped_.add({records_.position() - record.whole.size(), record.whole.size(), std::nullopt, fault.why});
    is_behind_skipped_ = true;
    items_.miss_channels();
}

void McapReader::process_skipped_index(const mcap::Record& record) {
    constexpr std::size_t entry_size = 2 * sizeof(std::uint64_t);
    mcap::Fields fields{record.body};
    const auto channel = fields.number<std::uint16_t>();
    const std::uint64_t count = fields.text().size() / entry_size;
    skipped_by_channel_[channel] += count;
    if (skipped_.count > skipped_.first.size()) return;    // it is not in `first`
    auto& messages = skipped_.first.back().messages;
    messages = messages.value_or(0) + count;
}

SkippedParts McapReader::skipped() const {
    SkippedParts skipped = skipped_;
    for (const auto& [channel, messages] : skipped_by_channel_)
        if (items_.has_frames(channel)) skipped.frames += messages;
    return skipped;
}

bool McapReader::is_strange() const noexcept {
    return records_.position() > mcap::magic.size() && !has_head_ && !items_.has_channel() && skipped_.count == 0;
}

}    // namespace anogate
