// A recording truncated at any byte is repaired.
#include <ano/wire.hpp>
#include <record/crc32.hpp>
#include <record/mcap/mcap_format.hpp>
#include <record/recording_repair.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/recorded.hpp>

namespace recording_repair_tests {
namespace {

using namespace anogate;
using support::KeptItem;
using support::read_recording;

const RecordingHead head{"anogated 0.1.0", 1'763'898'044'123'456'789, 1'234'567'890'123};

RecordingRepair::Result repair(RecordingFormat format, std::string_view file, std::size_t step = 4096) {
    RecordingRepair repair{format};
    for (std::size_t at = 0; at < file.size(); at += step) repair.feed(file.substr(at, step));
    return repair.finish();
}

std::string repaired(std::string_view file, const RecordingRepair::Result& result) {
    return std::string{file.substr(0, result.keep)} + result.append;
}

std::vector<KeptItem> flight(std::size_t frames) {
    std::vector<KeptItem> items;
    for (std::size_t i = 0; i < frames; ++i) {
        KeptItem item;
        item.time_ns = head.time_ns + i * 1000;
        item.boottime_ns = head.boottime_ns + i * 1000;
        item.link = i % 3 == 0 ? "ground" : "fc";
        item.description = "serial";
        if (i % 5 == 4) {
            item.direction = Direction::dropped;
            item.cause = "limited";
        }
        item.frame = support::frame(0xDC, 0xFF, 0x03,
                                    {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8), 0, 0, 0, 0, 1});
        items.push_back(item);
        if (i % 7 == 3) {
            KeptItem loss;
            loss.lost = i;
            loss.names = "euler " + std::to_string(i);
            items.push_back(loss);
        }
    }
    return items;
}

class Repair : public testing::TestWithParam<RecordingFormat> {};

TEST_P(Repair, keeps_everything_that_was_complete_before_a_cut_at_any_byte) {
    const auto items = flight(40);
    const std::string file = support::write_recording(GetParam(), items, head, true, 8);
    const std::size_t head_size = support::write_recording(GetParam(), {}, head, false).size();
    std::size_t most = 0;
    RecordingRepair growing{GetParam()};
    RecordingRepair::Result before;
    for (std::size_t size = 0; size <= file.size(); growing.feed(std::string_view{file}.substr(size++, 1))) {
        const auto cut = std::string_view{file}.substr(0, size);
        const auto result = growing.finish();
        ASSERT_EQ(result.is_recording, size >= head_size) << size;
        if (!result.is_recording) continue;
        ASSERT_LE(result.keep, size);
        if (result.keep == before.keep && result.append == before.append) continue;    // the same file
        before = result;
        const std::string made = repaired(cut, result);
        const auto read = read_recording(made), whole = read_recording(cut);
        ASSERT_EQ(read.fault, "") << size;
        ASSERT_TRUE(read.has_end) << size;
        ASSERT_EQ(read.unfinished, 0u) << size;
        ASSERT_EQ(read.items, whole.items) << size;
        ASSERT_GE(read.items.size(), most) << size;
        most = read.items.size();
        const auto again = repair(GetParam(), made);
        ASSERT_TRUE(again.is_whole) << size;
        ASSERT_EQ(again.keep, made.size()) << size;
        ASSERT_EQ(again.append, "") << size;
        ASSERT_EQ(again.frames, result.frames) << size;
    }
    EXPECT_EQ(most, items.size());
    EXPECT_TRUE(repair(GetParam(), file).is_whole);
}

std::uint64_t frames_in(std::string_view file) {
    const auto items = read_recording(file, 65536).items;
    return static_cast<std::uint64_t>(
        std::count_if(items.begin(), items.end(), [](const KeptItem& item) { return !item.frame.empty(); }));
}

TEST_P(Repair, repairs_a_file_cut_at_every_byte_of_its_last_mebibyte) {
    constexpr std::size_t mebibyte = 1024 * 1024, frames = 280, frame_size = 4000;
    support::Random random{1};
    auto items = flight(frames);
    for (KeptItem& item : items) {
        if (item.frame.empty()) continue;
        support::Bytes data(frame_size);    // that can't be compressed
        for (auto& byte : data) byte = random.byte();
        item.frame = support::frame(0xDC, 0xFF, 0xFB, data);
    }
    const std::string file = support::write_recording(GetParam(), items, head, true, 16);
    ASSERT_GT(file.size(), mebibyte);
    RecordingRepair growing{GetParam()};
    std::size_t at = file.size() - mebibyte, files = 0;
    growing.feed(std::string_view{file}.substr(0, at));
    RecordingRepair::Result before;
    for (; at <= file.size(); ++at) {
        const auto result = growing.finish();
        ASSERT_TRUE(result.is_recording);
        ASSERT_LE(result.keep, at);
        ASSERT_TRUE(at < file.size() || result.is_whole);
        if (result.keep != before.keep) {
            ASSERT_GT(result.keep, before.keep);
            ASSERT_GE(result.frames, before.frames);
            if (++files % 8 == 1 || at + 5000 > file.size()) {    // reading takes time
                const std::string made = repaired(file, result);
                ASSERT_EQ(frames_in(made), result.frames) << at;
                ASSERT_TRUE(repair(GetParam(), made, 65536).is_whole) << at;
            }
            before = result;
        } else if (result.append != before.append) {
            ASSERT_TRUE(result.is_whole || result.append.empty()) << at;    // within the end of the file
        }
        if (at < file.size()) growing.feed(std::string_view{file}.substr(at, 1));
    }
    EXPECT_EQ(before.frames, frames);
    EXPECT_GT(files, 10u);
}

TEST_P(Repair, restores_the_same_bytes_if_a_file_is_cut_after_its_last_frame) {
    const std::string file = support::write_recording(GetParam(), flight(40), head, true, 8);
    const std::string unended = support::write_recording(GetParam(), flight(40), head, false, 8);
    ASSERT_TRUE(file.starts_with(unended));
    RecordingRepair growing{GetParam()};
    growing.feed(unended);
    for (std::size_t size = unended.size(); size < file.size(); growing.feed(std::string_view{file}.substr(size++, 1))) {
        if (GetParam() == RecordingFormat::mcap) {
            ASSERT_EQ(repaired(std::string_view{file}.substr(0, size), growing.finish()), file) << size;
        }
    }
    EXPECT_EQ(repaired(unended, repair(GetParam(), unended)), file);
}

TEST_P(Repair, cuts_off_zeros_or_garbage_left_by_a_power_loss) {
    const auto items = flight(40);
    const std::string file = support::write_recording(GetParam(), items, head, false, 8);
    for (const std::string& rest : {std::string(5000, '\0'), std::string(5000, '\xA5'), file.substr(file.size() / 2)}) {
        const std::string damaged = file + rest;
        const auto read = read_recording(repaired(damaged, repair(GetParam(), damaged)));
        EXPECT_EQ(read.fault, "");
        EXPECT_TRUE(read.has_end);
        ASSERT_GE(read.items.size(), items.size());
        EXPECT_TRUE(std::equal(items.begin(), items.end(), read.items.begin()));
    }
}

// As other programs check it; always true for pcapng, which has no checksum.
bool has_the_checksum_that_it_tells(std::string_view file) {
    std::string_view rest = file.substr(mcap::magic.size());
    while (const auto record = mcap::next_record(rest)) {
        if (record->opcode != mcap::Opcode::data_end) continue;
        const auto data = file.substr(0, static_cast<std::size_t>(record->whole.data() - file.data()));
        return mcap::Fields{record->body}.number<std::uint32_t>() == crc32_of(data);
    }
    return !file.starts_with(mcap::magic);
}

bool has_indexes_right_behind_their_chunks(std::string_view file) {
    std::string_view rest = file.substr(mcap::magic.size());
    while (const auto record = mcap::next_record(rest)) {
        if (record->opcode != mcap::Opcode::chunk_index) continue;
        mcap::Fields fields{record->body};
        fields.bytes(2 * sizeof(std::uint64_t));    // times
        const auto at = fields.number<std::uint64_t>(), size = fields.number<std::uint64_t>();
        mcap::Fields offsets{fields.text()};
        const std::uint64_t end = at + size + fields.number<std::uint64_t>();
        while (!offsets.rest().empty()) {
            offsets.number<std::uint16_t>();
            const auto offset = offsets.number<std::uint64_t>();
            if (offset < at + size || offset >= end) return false;
        }
    }
    return true;
}

TEST_P(Repair, keeps_a_damaged_part_if_valid_data_follows) {
    const auto items = flight(40);
    const std::string file = support::write_recording(GetParam(), items, head, false, 8);
    std::string damaged = file;
    const bool is_mcap = GetParam() == RecordingFormat::mcap;
    std::size_t last = 0;    // the position of the last chunk or packet
    if (is_mcap) {
        std::string_view rest = std::string_view{file}.substr(mcap::magic.size());
        std::vector<std::size_t> ends;
        while (const auto record = mcap::next_record(rest)) {
            if (record->opcode != mcap::Opcode::chunk) continue;
            last = static_cast<std::size_t>(record->whole.data() - file.data());
            ends.push_back(last + record->whole.size());
        }
        damaged[ends.at(1) - 1] ^= 0x55;
    } else {
        const auto word_at = [&](std::size_t at) {
            return ano::load<std::uint32_t>(reinterpret_cast<const std::uint8_t*>(file.data()) + at);
        };
        std::vector<std::size_t> packets;
        for (std::size_t at = 0; at < file.size(); at += word_at(at + 4))
            if (word_at(at) == 6) packets.push_back(at);
        last = packets.back();
        damaged[packets.at(10) + 8] = '\x7F';    // its interface
    }
    const auto read = read_recording(damaged);
    ASSERT_EQ(read.skipped.count, 1u);
    ASSERT_LT(read.items.size(), items.size());
    const auto result = repair(GetParam(), damaged);
    EXPECT_EQ(result.keep + result.append.size(), repaired(damaged, result).size());
    const auto again = read_recording(repaired(damaged, result));
    EXPECT_EQ(again.items, read.items);
    EXPECT_TRUE(again.has_end);
    EXPECT_EQ(again.skipped, read.skipped);
    EXPECT_TRUE(has_the_checksum_that_it_tells(repaired(damaged, result)));
    if (is_mcap) {
        EXPECT_TRUE(has_indexes_right_behind_their_chunks(repaired(damaged, result)));
    }
    EXPECT_TRUE(repair(GetParam(), repaired(damaged, result)).is_whole);
    // After the last one there is nothing valid: it is removed.
    std::string bad_end = file;
    if (is_mcap) bad_end[last + 40] ^= 0x55;
    else bad_end[last + 8] = '\x7F';
    const auto cut = repair(GetParam(), bad_end);
    EXPECT_LE(cut.keep, last);
    EXPECT_TRUE(has_the_checksum_that_it_tells(repaired(bad_end, cut)));
    if (is_mcap) {
        EXPECT_TRUE(has_indexes_right_behind_their_chunks(repaired(bad_end, cut)));
    }
    const auto rest = read_recording(repaired(bad_end, cut));
    EXPECT_EQ(rest.skipped.count, 0u);
    EXPECT_TRUE(rest.has_end);
    EXPECT_EQ(rest.items, read_recording(bad_end).items);
}

TEST_P(Repair, returns_the_same_result_for_input_in_pieces) {
    const std::string file = support::write_recording(GetParam(), flight(40), head, true, 8);
    const auto cut = std::string_view{file}.substr(0, file.size() * 2 / 3);
    const auto whole = repair(GetParam(), cut, cut.size()), pieces = repair(GetParam(), cut, 7);
    EXPECT_EQ(whole.keep, pieces.keep);
    EXPECT_EQ(whole.append, pieces.append);
    EXPECT_EQ(whole.frames, pieces.frames);
}

TEST_P(Repair, leaves_files_that_are_not_recordings_unchanged) {
    for (const std::string file : {"", "text", "\x89MCAP0\r\n", "\x0A\x0D\x0D\x0A"}) {
        EXPECT_FALSE(repair(GetParam(), file).is_recording);
    }
}

std::string name_of(const testing::TestParamInfo<RecordingFormat>& info) { return std::string{text(info.param)}; }

INSTANTIATE_TEST_SUITE_P(Of, Repair, testing::Values(RecordingFormat::pcapng, RecordingFormat::mcap), name_of);

}    // namespace
}    // namespace recording_repair_tests
