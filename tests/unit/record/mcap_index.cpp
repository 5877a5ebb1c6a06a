#include <record/mcap/mcap_index.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include <support/bytes.hpp>
#include <support/recorded.hpp>

namespace mcap_index_tests {
namespace {

using namespace anogate;
using support::KeptItem;

const RecordingHead head{"anogated 0.1.0", 1'763'898'044'123'456'789, 1'234'567'890'123};

std::vector<KeptItem> flight(std::size_t frames) {
    std::vector<KeptItem> items(frames);
    for (std::size_t i = 0; i < frames; ++i) {
        items[i].time_ns = head.time_ns + i * 1'000'000;
        items[i].boottime_ns = head.boottime_ns + i * 1'000'000;
        items[i].link = "fc";
        items[i].frame = support::frame(0xDC, 0xFF, 0x03, support::Bytes(500, static_cast<std::uint8_t>(i * 7919 >> 4)));
    }
    KeptItem loss;
    loss.lost = 7;
    loss.names = "euler 7";
    items.push_back(loss);
    return items;
}

struct Reading {
    std::optional<McapIndex> index;
    std::size_t bytes = 0;    // bytes read
};

Reading read_index(const std::string& file) {
    Reading reading;
    reading.index = read_mcap_index(file.size(), [&](std::uint64_t at, std::size_t size) {
        const std::string bytes = at < file.size() ? file.substr(static_cast<std::size_t>(at), size) : "";
        reading.bytes += bytes.size();
        return bytes;
    });
    return reading;
}

TEST(McapIndex, returns_the_totals_of_the_file_and_reads_little_of_it) {
    const auto items = flight(3000);
    std::string file;
    const auto writer = make_recording_writer(RecordingFormat::mcap, head, file,
                                              {.encoding = DecodedEncoding::cdr, .packed = false});
    RecordingCounts counts;
    for (const KeptItem& item : items) {
        if (item.frame.empty()) {
            writer->write(RecordedLoss{item.lost, item.names});
            counts.add(RecordedLoss{item.lost, item.names});
        } else {
            writer->write(support::frame_of(item), file);
            counts.add(support::frame_of(item));
        }
    }
    writer->end(file);
    const Reading reading = read_index(file);
    ASSERT_TRUE(reading.index);
    EXPECT_EQ(reading.index->counts, counts);
    EXPECT_EQ(reading.index->head.program, head.program);
    EXPECT_EQ(reading.index->head.boottime_ns, head.boottime_ns);
    EXPECT_LT(reading.bytes, file.size() / 100);
}

TEST(McapIndex, is_rejected_if_the_file_is_cut_at_any_byte) {
    const std::string file = support::write_recording(RecordingFormat::mcap, flight(5), head);
    ASSERT_TRUE(read_index(file).index);
    for (std::size_t size = 0; size < file.size(); ++size) ASSERT_FALSE(read_index(file.substr(0, size)).index) << size;
}

TEST(McapIndex, is_rejected_if_any_byte_of_the_summary_differs) {
    const std::string file = support::write_recording(RecordingFormat::mcap, flight(5), head);
    const std::string schema = "ano_msgs/msg/RecordedFrame";    // its first occurrence: in the data it is compressed
    const std::size_t summary = file.find(schema);
    ASSERT_NE(summary, std::string::npos);
    for (std::size_t at = summary; at < file.size(); ++at) {
        std::string damaged = file;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x20);
        ASSERT_FALSE(read_index(damaged).index) << at;
    }
}

TEST(McapIndex, is_rejected_if_the_counts_contradict_the_statistics) {
    std::string file = support::write_recording(RecordingFormat::mcap, flight(5), head);
    const std::size_t frames = file.find("{\"frames\":5,");
    ASSERT_NE(frames, std::string::npos);
    file[file.find('5', frames)] = '4';
    EXPECT_FALSE(read_index(file).index);
}

TEST(McapIndex, is_rejected_if_the_file_cannot_be_read) {
    EXPECT_FALSE(read_mcap_index(1 << 30, [](std::uint64_t, std::size_t) { return std::string{}; }));
    EXPECT_FALSE(read_mcap_index(~std::uint64_t{0}, [](std::uint64_t, std::size_t size) { return std::string(size, '\xFF'); }));
}

}    // namespace
}    // namespace mcap_index_tests
