#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <record/crc32.hpp>
#include <record/mcap/mcap_chunk.hpp>
#include <record/mcap/mcap_items.hpp>
#include <record/mcap/mcap_reader.hpp>
#include <record/mcap/mcap_writer.hpp>
#include <support/bytes.hpp>
#include <support/recorded.hpp>
#include <support/recorded_items.hpp>

namespace mcap_tests {
namespace {

using namespace anogate;
using support::Bytes;
using support::came;
using support::KeptItem;
using support::lost;
using support::read_recording;

const RecordingHead& head = support::anoctl_head;
const Bytes& euler = support::euler_frame;
const Bytes& wind = support::wind_frame;

std::vector<KeptItem> a_bit_of_everything() {
    KeptItem first = came(euler);
    first.description = "serial /dev/ttyUSB0";
    KeptItem sent = came(wind, "ground");
    sent.direction = Direction::out;
    sent.channel = 3;
    sent.peer = "192.168.1.20:6000";
    KeptItem dropped = sent;
    dropped.direction = Direction::dropped;
    dropped.cause = "limited";
    dropped.description = "udp-listen 0.0.0.0:12333";
    KeptItem other = sent;
    other.channel = 255;
    other.peer = "";
    other.boottime_ns = 0;
    other.time_ns -= 3'600'000'000'000;    // the clock was set back
    return {first, sent, lost(7, "euler 4, power 3"), dropped, first, other, lost(2, "euler 2")};
}

std::string write_mcap(const std::vector<KeptItem>& items, bool end = true, std::size_t often = 0) {
    return support::write_recording(RecordingFormat::mcap, items, head, end, often);
}

// Every record of a file by its kind, except those in chunks.
std::vector<mcap::Record> records_of(std::string_view file) {
    std::vector<mcap::Record> all;
    file.remove_prefix(mcap::magic.size());
    while (const auto record = mcap::next_record(file)) all.push_back(*record);
    EXPECT_EQ(file, mcap::magic);
    return all;
}

std::vector<mcap::Record> records_of(std::string_view file, mcap::Opcode opcode) {
    std::vector<mcap::Record> all = records_of(file);
    std::erase_if(all, [&](const mcap::Record& record) { return record.opcode != opcode; });
    return all;
}

std::uint64_t place_of(const std::string& file, const mcap::Record& record) {
    return static_cast<std::uint64_t>(record.whole.data() - file.data());
}

TEST(Crc32, matches_the_crc_of_zip) {
    EXPECT_EQ(crc32_of("123456789"), 0xCBF43926u);
    EXPECT_EQ(crc32_of(""), 0u);
    Crc32 crc;
    for (const char c : std::string_view{"The quick brown fox jumps over the lazy dog"}) crc.add({&c, 1});
    EXPECT_EQ(crc.value(), 0x414FA339u);
    EXPECT_EQ(crc32_of("The quick brown fox jumps over the lazy dog"), 0x414FA339u);
}

TEST(Mcap, reads_back_everything_that_was_written) {
    const auto items = a_bit_of_everything();
    for (const std::size_t often : {0u, 1u, 3u}) {
        const auto read = read_recording(write_mcap(items, true, often), 5);
        EXPECT_EQ(read.items, items);
        EXPECT_EQ(read.head.program, head.program);
        EXPECT_EQ(read.head.time_ns, head.time_ns);
        EXPECT_EQ(read.head.boottime_ns, head.boottime_ns);
        EXPECT_TRUE(read.has_end);
        EXPECT_EQ(read.fault + std::to_string(read.unfinished), "0");
        EXPECT_EQ(read.foreign, 0u);
    }
}

TEST(Mcap, reports_that_a_recording_was_not_ended) {
    const auto read = read_recording(write_mcap({came(euler)}, false));
    EXPECT_FALSE(read.has_end);
    EXPECT_EQ(read.items.size(), 1u);
    const auto none = read_recording(write_mcap({}));
    EXPECT_TRUE(none.has_end);
    EXPECT_EQ(none.fault, "");
    EXPECT_TRUE(none.items.empty());
}

TEST(Mcap, flushed_data_is_read_from_a_file_that_ends_there) {
    std::string file;
    McapWriter writer{head, file};
    const KeptItem item = came(euler);
    for (std::size_t i = 1; i <= 5; ++i) {
        writer.write(support::frame_of(item), file);
        writer.flush(file);
        EXPECT_EQ(read_recording(file).items.size(), i);
    }
    const std::size_t before = file.size();
    writer.flush(file);
    EXPECT_EQ(file.size(), before);    // nothing new was written
}

TEST(Mcap, returns_all_complete_items_before_a_cut_at_any_byte) {
    const auto items = a_bit_of_everything();
    const std::string file = write_mcap(items, true, 2);
    std::vector<KeptItem> read;
    McapReader reader;
    for (std::size_t size = 1; size <= file.size(); ++size) {
        reader.feed(std::string_view{file}.substr(size - 1, 1));
        while (const auto item = reader.next()) read.push_back(support::kept(*item));
        ASSERT_FALSE(reader.is_damaged()) << size;
        ASSERT_EQ(reader.position() + reader.unfinished(), size);
        ASSERT_EQ(reader.has_end(), size == file.size());
        ASSERT_LE(read.size(), items.size());
        ASSERT_TRUE(std::equal(read.begin(), read.end(), items.begin())) << size;
    }
    EXPECT_EQ(read, items);
}

TEST(Mcap, a_chunk_is_ended_when_it_has_a_mebibyte) {
    const Bytes large = support::frame(0xDC, 0xFE, 0xFB, Bytes(60000));
    std::string file;
    McapWriter writer{head, file};
    const std::size_t begin = file.size();
    const KeptItem item = came(large);
    std::size_t frames = 0;
    while (file.size() == begin) {
        writer.write(support::frame_of(item), file);
        ++frames;
    }
    EXPECT_LE(frames * large.size(), McapWriter::enough + 2 * large.size());
    EXPECT_EQ(read_recording(file).items.size(), frames);
}

// Messages as other programs find them: summary, chunk index, message index.
TEST(Mcap, indexes_lead_to_every_message) {
    const auto items = a_bit_of_everything();
    const std::string file = write_mcap(items, true, 2);
    std::map<std::uint64_t, std::size_t> found;    // by log_time
    mcap::ChunkOpener opener;
    for (const auto& record : records_of(file, mcap::Opcode::chunk_index)) {
        mcap::Fields fields{record.body};
        const auto first = fields.number<std::uint64_t>(), last = fields.number<std::uint64_t>();
        const auto at = fields.number<std::uint64_t>(), size = fields.number<std::uint64_t>();
        mcap::Fields offsets{fields.text()};
        const auto index_size = fields.number<std::uint64_t>();
        EXPECT_EQ(fields.text(), "zstd");
        std::string_view there = std::string_view{file}.substr(at, size);
        const auto chunk = mcap::chunk_of(mcap::next_record(there)->body);
        ASSERT_TRUE(chunk && there.empty());
        EXPECT_EQ(chunk->records.size(), fields.number<std::uint64_t>());
        EXPECT_EQ(chunk->unpacked_size, fields.number<std::uint64_t>());
        EXPECT_EQ(chunk->first_time, first);
        EXPECT_EQ(chunk->last_time, last);
        EXPECT_LE(first, last);
        std::string inner;
        ASSERT_EQ(opener.open(*chunk, inner).why, nullptr);
        std::uint64_t all_index_bytes = 0;
        while (!offsets.rest().empty()) {
            const auto channel = offsets.number<std::uint16_t>();
            std::string_view behind = std::string_view{file}.substr(offsets.number<std::uint64_t>());
            const auto index = mcap::next_record(behind);
            ASSERT_TRUE(index && index->opcode == mcap::Opcode::message_index);
            all_index_bytes += index->whole.size();
            mcap::Fields entries{index->body};
            EXPECT_EQ(entries.number<std::uint16_t>(), channel);
            mcap::Fields entry{entries.text()};
            while (!entry.rest().empty()) {
                const auto time = entry.number<std::uint64_t>();
                std::string_view message_at = std::string_view{inner}.substr(entry.number<std::uint64_t>());
                const auto message = mcap::message_of(mcap::next_record(message_at)->body);
                ASSERT_TRUE(message);
                EXPECT_EQ(message->log_time, time);
                EXPECT_EQ(message->channel, channel);
                EXPECT_TRUE(first <= time && time <= last);
                if (channel <= 2) ++found[time];
            }
        }
        EXPECT_EQ(index_size, all_index_bytes);
    }
    EXPECT_EQ(found[head.time_ns + 1], 5u);
    EXPECT_EQ(found[head.time_ns + 1 - 3'600'000'000'000], 2u);    // the last loss has the time of the previous frame
}

TEST(Mcap, a_loss_without_a_following_frame_is_written_by_a_flush) {
    const std::string file = write_mcap({came(euler), lost(7, "euler 7")}, false,
                                        1);    // without an end, as of a killed program
    const auto items = read_recording(file).items;
    ASSERT_EQ(items.size(), 2u);
    EXPECT_EQ(items[1].lost, 7u);
    EXPECT_EQ(items[1].names, "euler 7");
    const auto more = read_recording(write_mcap({came(euler), lost(7, "euler 7"), came(euler)}, true, 1)).items;
    ASSERT_EQ(more.size(), 3u) << "not once more with the next frame";
}

TEST(Mcap, checksums_and_offsets_match_the_bytes) {
    const std::string file = write_mcap(a_bit_of_everything(), true, 2);
    const mcap::Record end = records_of(file, mcap::Opcode::data_end).at(0),
                       footer = records_of(file, mcap::Opcode::footer).at(0);
    EXPECT_EQ(mcap::Fields{end.body}.number<std::uint32_t>(), crc32_of(std::string_view{file}.substr(0, place_of(file, end))));
    mcap::Fields fields{footer.body};
    const auto summary = fields.number<std::uint64_t>(), offsets = fields.number<std::uint64_t>();
    EXPECT_EQ(summary, place_of(file, end) + end.whole.size());
    EXPECT_EQ(offsets, place_of(file, records_of(file, mcap::Opcode::summary_offset).at(0)));
    const std::size_t crc_at = file.size() - mcap::magic.size() - 4;
    EXPECT_EQ(fields.number<std::uint32_t>(), crc32_of(std::string_view{file}.substr(summary, crc_at - summary)));
    for (const auto& record : records_of(file, mcap::Opcode::summary_offset)) {
        mcap::Fields group{record.body};
        const auto kind = static_cast<mcap::Opcode>(group.number<std::uint8_t>());
        const auto at = group.number<std::uint64_t>(), size = group.number<std::uint64_t>();
        std::string_view rest = std::string_view{file}.substr(at, size);
        std::size_t count = 0;
        while (const auto one = mcap::next_record(rest)) count += one->opcode == kind;
        EXPECT_TRUE(rest.empty());
        EXPECT_EQ(count, records_of(file, kind).size());
    }
    for (const auto& record : records_of(file, mcap::Opcode::metadata_index)) {
        mcap::Fields index{record.body};
        const auto at = index.number<std::uint64_t>(), size = index.number<std::uint64_t>();
        std::string_view there = std::string_view{file}.substr(at, size);
        const auto metadata = mcap::next_record(there);
        ASSERT_TRUE(metadata && there.empty());
        EXPECT_EQ(mcap::name_of_metadata(metadata->body), index.text());
    }
}

TEST(Mcap, counts_messages_that_are_not_a_complete_frame_and_continues) {
    Bytes broken = euler;
    broken.back() ^= 1;
    const auto read = read_recording(write_mcap({came(broken), came(wind)}));
    EXPECT_EQ(read.foreign, 1u);
    ASSERT_EQ(read.items.size(), 1u);
    EXPECT_EQ(read.items[0].frame, wind);
}

TEST(Mcap, reports_why_it_cannot_read_a_file) {
    EXPECT_EQ(read_recording("\x89PNG\r\n\x1A\n").fault, "it is not an MCAP file");
    EXPECT_EQ(read_recording("\x89MCAP1\r\n").fault, "it uses an unsupported version of MCAP");
    const std::string file = write_mcap(a_bit_of_everything());
    EXPECT_EQ(read_recording(file + "x").fault, "there is data after its end");
    std::string other_end = file;
    other_end.back() = '\r';
    EXPECT_EQ(read_recording(other_end).fault, "it does not end like an MCAP file");
    EXPECT_EQ(read_recording(write_mcap({came(euler)}, false) + std::string(100, '\0')).fault,
              "it has a record of an unknown type");    // zeros: power was lost
}

std::string file_of(const std::string& records) { return std::string{mcap::magic} + records; }

std::string chunk_record(std::string_view compression, std::string_view bytes, std::uint64_t size, std::uint32_t crc = 0) {
    std::string record;
    const std::size_t begun = mcap::begin_record(record, mcap::Opcode::chunk);
    mcap::append_le(record, std::uint64_t{0});
    mcap::append_le(record, std::uint64_t{0});
    mcap::append_le(record, size);
    mcap::append_le(record, crc);
    mcap::append_string(record, compression);
    mcap::append_le(record, static_cast<std::uint64_t>(bytes.size()));
    record += bytes;
    mcap::end_record(record, begun);
    return record;
}

TEST(Mcap, a_chunk_that_contradicts_its_header_is_not_read) {
    const auto fault_of = [](const std::string& record) { return read_recording(file_of(record)).fault; };
    const auto skipped = [](const std::string& record) -> std::string {
        const auto read = read_recording(file_of(record));
        EXPECT_EQ(read.fault, "");
        return read.skipped.count == 1 ? std::string{read.skipped.first.front().why} : "";
    };
    std::string packed;
    ZstdPacker{}.pack(std::string(1000, '\1'), packed);
    EXPECT_EQ(skipped(chunk_record("zstd", packed, 999)), "it can't be decompressed");
    EXPECT_EQ(skipped(chunk_record("zstd", packed, 1001)), "it can't be decompressed");
    EXPECT_EQ(skipped(chunk_record("zstd", packed.substr(0, packed.size() - 1), 1000)), "it can't be decompressed");
    EXPECT_EQ(skipped(chunk_record("zstd", packed + "x", 1000)), "it can't be decompressed");
    EXPECT_EQ(skipped(chunk_record("zstd", packed, 1000, 1)), "its checksum is wrong");
    EXPECT_EQ(skipped(chunk_record("zstd", packed, 1000)), "a record in it extends beyond its end");
    EXPECT_EQ(skipped(chunk_record("", "abc", 4)), "its length is not the length in its header");
    EXPECT_EQ(skipped(chunk_record("", "abc", 3)), "a record in it extends beyond its end");
    EXPECT_EQ(skipped(chunk_record("zstd", "", mcap::max_chunk + 1)), "it is longer than 64 MiB");
    std::string no_chunk;
    mcap::end_record(no_chunk, mcap::begin_record(no_chunk, mcap::Opcode::chunk));
    EXPECT_EQ(skipped(no_chunk), "it is shorter than its header states");
    EXPECT_NE(fault_of(chunk_record("lz4", "abc", 3)).find("mcap compress --compression zstd"), std::string::npos);
    EXPECT_EQ(fault_of(chunk_record("br", "abc", 3)), "its chunks use an unknown compression");
    std::string endless;
    mcap::append_le(endless, std::uint8_t{6});
    mcap::append_le(endless, ~std::uint64_t{0});
    EXPECT_EQ(fault_of(endless), "a record is longer than 64 MiB");
}

// Many chunks of two frames each; those with these numbers are damaged in their compressed data.
struct DamagedFile {
    std::string bytes;
    std::vector<KeptItem> items;
    std::vector<std::uint64_t> damaged_at;
};
DamagedFile with_damaged_chunks(const std::vector<std::size_t>& damaged, bool end = true) {
    DamagedFile file;
    constexpr std::size_t chunks = 5, in_chunk = 2;
    for (std::size_t i = 0; i < chunks * in_chunk; ++i) {
        file.items.push_back(came(i % 2 == 0 ? euler : wind));
        file.items.back().time_ns += i;
    }
    file.bytes = write_mcap(file.items, end, in_chunk);
    std::size_t number = 0;
    std::string_view rest = std::string_view{file.bytes}.substr(mcap::magic.size());
    std::vector<std::size_t> places;
    while (const auto record = mcap::next_record(rest)) {
        if (record->opcode != mcap::Opcode::chunk) continue;
        if (std::find(damaged.begin(), damaged.end(), number++) == damaged.end()) continue;
        file.damaged_at.push_back(place_of(file.bytes, *record));
        places.push_back(place_of(file.bytes, *record) + record->whole.size() - 1);
    }
    for (const std::size_t place : places) file.bytes[place] = static_cast<char>(file.bytes[place] ^ 0x55);
    for (auto at = damaged.rbegin(); at != damaged.rend(); ++at) {
        const auto first = file.items.begin() + static_cast<std::ptrdiff_t>(*at * in_chunk);
        file.items.erase(first, first + in_chunk);
    }
    return file;
}

TEST(Mcap, continues_after_a_damaged_chunk_and_reports_its_content) {
    const DamagedFile file = with_damaged_chunks({1, 3});
    for (const std::size_t step : {std::size_t{7}, std::size_t{65536}}) {
        const auto read = read_recording(file.bytes, step);
        EXPECT_EQ(read.fault, "");
        EXPECT_TRUE(read.has_end);
        EXPECT_EQ(read.position, file.bytes.size());
        EXPECT_EQ(read.items, file.items);
        ASSERT_EQ(read.skipped.count, 2u);
        ASSERT_EQ(read.skipped.first.size(), 2u);
        EXPECT_EQ(read.skipped.frames, 4u);
        EXPECT_EQ(read.skipped.first[0].at, file.damaged_at[0]);
        EXPECT_EQ(read.skipped.first[1].at, file.damaged_at[1]);
        EXPECT_EQ(read.skipped.bytes, read.skipped.first[0].size + read.skipped.first[1].size);
        // Two frames, their decoded messages, and the orientation.
        EXPECT_EQ(read.skipped.first[0].messages, std::optional<std::uint64_t>{5});
    }
}

// The damaged chunk contained the channel of frames.
TEST(Mcap, finds_frames_even_if_the_chunk_with_their_channel_is_damaged) {
    for (const bool is_ended : {true, false}) {
        const DamagedFile file = with_damaged_chunks({0}, is_ended);
        const auto read = read_recording(file.bytes);
        EXPECT_EQ(read.items, file.items);
        EXPECT_EQ(read.skipped.count, 1u);
        EXPECT_EQ(read.skipped.frames, 2u);
        EXPECT_EQ(read.foreign, 0u);
    }
}

TEST(Mcap, lists_only_the_first_of_many_damaged_chunks_one_by_one) {
    std::string records;
    constexpr std::uint64_t count = SkippedParts::max_listed + 3;
    std::string index;    // of one message
    const std::size_t begun = mcap::begin_record(index, mcap::Opcode::message_index);
    mcap::append_le(index, std::uint16_t{1});
    mcap::append_string(index, std::string(2 * sizeof(std::uint64_t), '\0'));
    mcap::end_record(index, begun);
    for (std::uint64_t i = 0; i < count; ++i) records += chunk_record("", "abc", 4) + index;
    const auto read = read_recording(file_of(records));
    EXPECT_EQ(read.skipped.count, count);
    EXPECT_EQ(read.skipped.bytes, records.size() - count * index.size());
    ASSERT_EQ(read.skipped.first.size(), SkippedParts::max_listed);
    EXPECT_EQ(read.skipped.first.back().at, mcap::magic.size() + (SkippedParts::max_listed - 1) * (records.size() / count));
    EXPECT_EQ(read.skipped.first.back().messages, std::optional<std::uint64_t>{1});
    const std::string alone = chunk_record("", "abc", 4);
    EXPECT_EQ(read_recording(file_of(alone)).skipped.first.at(0).messages, std::nullopt);
}

TEST(Mcap, a_decompression_bomb_uses_no_more_memory_than_a_chunk_may_have) {
    std::string packed;
    ZstdPacker{}.pack(std::string(mcap::max_chunk + 1000, '\0'), packed);
    EXPECT_LT(packed.size(), 10000u);
    std::string out;
    EXPECT_FALSE(ZstdUnpacker{}.unpack(packed, 5000, out));
    EXPECT_LE(out.capacity(), 2u * 1024 * 1024);
}

TEST(Mcap, a_chunk_in_a_chunk_is_ignored) {
    const std::string inner = chunk_record("", "", 0);
    const auto read = read_recording(file_of(chunk_record("", inner + inner, 2 * inner.size())));
    EXPECT_EQ(read.fault, "");
    EXPECT_TRUE(read.items.empty());
}

// As saved by `mcap` and others: without chunks, with other numbers, with additional fields after the known ones.
TEST(Mcap, reads_files_saved_by_other_programs) {
    const KeptItem item = came(wind, "radio");
    std::string data, file;
    mcap::encode(support::frame_of(item), data);
    const std::size_t header = mcap::begin_record(file, mcap::Opcode::header);
    mcap::append_string(file, "");
    mcap::append_string(file, "somebody");
    file += "more";
    mcap::end_record(file, header);
    mcap::append_schema(file, {77, mcap::frame_schema_name, "ros2msg", mcap::frame_schema_text});
    mcap::append_channel(file, {900, 77, mcap::frames_topic, "cdr"});
    mcap::append_channel(file, {901, 77, "/other", "cdr"});
    mcap::append_message(file, {901, 0, 1, 1, data});
    mcap::append_message(file, {902, 0, 1, 1, data});    // of a channel that is not declared
    mcap::append_message(file, {900, 0, item.time_ns, item.time_ns, data});
    file += '\x90';    // of another program
    mcap::append_le(file, std::uint64_t{3});
    file += "abc";
    const auto read = read_recording(file_of(file));
    EXPECT_EQ(read.fault, "");
    EXPECT_EQ(read.items, std::vector<KeptItem>{item});
}

TEST(Mcap, reports_whether_a_file_contains_gateway_data) {
    std::string records;
    mcap::append_channel(records, {1, 0, "/camera", "cdr"});
    mcap::append_message(records, {1, 0, 1, 1, "abc"});
    McapReader strange;
    strange.feed(file_of(records));
    EXPECT_FALSE(strange.next());
    EXPECT_TRUE(strange.is_strange());
    McapReader ours;
    ours.feed(write_mcap({}));
    EXPECT_FALSE(ours.next());
    EXPECT_FALSE(ours.is_strange());
}

TEST(Mcap, a_message_that_is_not_valid_cdr_is_rejected) {
    std::string good;
    mcap::encode(support::frame_of(came(euler)), good);
    const auto read_with = [](std::string_view data) {
        mcap::Items items;
        std::string channel;
        mcap::append_channel(channel, {1, 1, mcap::frames_topic, "cdr"});
        items.add_channel(channel.substr(mcap::record_head));
        return items.item_of({1, 0, 1, 1, data}).has_value();
    };
    EXPECT_TRUE(read_with(good));
    for (std::size_t size = 0; size < good.size(); ++size)
        EXPECT_FALSE(read_with(std::string_view{good}.substr(0, size))) << size;
    std::string big_endian = good;
    big_endian[1] = 0;
    EXPECT_FALSE(read_with(big_endian));
    KeptItem out = came(euler);
    out.direction = Direction::out;
    std::string direction;
    mcap::encode(support::frame_of(out), direction);
    const auto differs = std::mismatch(good.begin(), good.end(), direction.begin()).second;
    *differs = 3;
    EXPECT_FALSE(read_with(direction));
    for (std::size_t at = 4; at < good.size(); ++at) {
        std::string long_text = good;
        long_text[at] = '\xFF';
        read_with(long_text);    // detects invalid reads under the sanitizers
    }
}

TEST(Mcap, long_texts_are_cut_between_characters) {
    KeptItem item = came(euler, std::string(1023, 'x') + "温度");
    EXPECT_EQ(read_recording(write_mcap({item})).items.at(0).link, std::string(1023, 'x'));
}

}    // namespace
}    // namespace mcap_tests
