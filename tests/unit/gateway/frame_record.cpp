#include <gateway/frame_record.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace frame_record_tests {

using namespace anogate;
using support::frame;

namespace {

const auto euler = frame(0xDC, 0xFE, 0x03, {1, 2, 3});
const auto empty = frame(1, 2, 4);

FrameRecord record_of(const support::Bytes& bytes) { return {0, 0, 0, Direction::in, 0, 0, ano::FrameView{bytes}}; }

TEST(FrameRecord, has_the_documented_layout_byte_by_byte) {
    std::string records;
    append(records, {0x0807060504030201, 0x1817161514131211, 3, Direction::dropped, 9, 63, ano::FrameView{empty}});
    const support::Bytes head = support::hex("01 02 03 04 05 06 07 08 11 12 13 14 15 16 17 18 03 02 09 3F");
    const support::Bytes wanted = support::operator+(head, empty);
    EXPECT_EQ(support::Bytes(records.begin(), records.end()), wanted);
}

TEST(FrameRecord, many_in_a_row_are_read_as_they_were_written) {
    std::string records;
    append(records, record_of(euler));
    append(records, {7, 8, 63, Direction::out, 0, FrameRecord::no_channel, ano::FrameView{empty}});
    std::string_view rest = records;
    const auto first = next_record(rest);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->frame.id(), 0x03);
    EXPECT_EQ(first->direction, Direction::in);
    const auto second = next_record(rest);
    ASSERT_TRUE(second);
    EXPECT_EQ(second->time_ns, 7u);
    EXPECT_EQ(second->boottime_ns, 8u);
    EXPECT_EQ(second->link, 63);
    EXPECT_EQ(second->direction, Direction::out);
    EXPECT_EQ(second->channel, FrameRecord::no_channel);
    EXPECT_TRUE(rest.empty());
    EXPECT_FALSE(next_record(rest));
}

TEST(FrameRecord, reports_that_the_source_belongs_to_another_link) {
    for (const Direction direction : {Direction::in, Direction::out, Direction::dropped}) {
        std::string records;
        append(records, {7, 8, 3, direction, 0, 5, ano::FrameView{euler}, true});
        EXPECT_EQ(static_cast<std::uint8_t>(records[17]), 0x80 | static_cast<std::uint8_t>(direction));
        std::string_view rest = records;
        const auto record = next_record(rest);
        ASSERT_TRUE(record);
        EXPECT_TRUE(record->is_elsewhere);
        EXPECT_EQ(record->direction, direction);
        records[17] = static_cast<char>(0x83);
        rest = records;
        EXPECT_FALSE(next_record(rest)) << "no direction";
    }
}

TEST(FrameRecord, may_have_the_bytes_on_the_wire) {
    const support::Bytes v7 = support::hex("AA FF 03 01 07 B4 16");
    std::string records;
    FrameRecord record = record_of(euler);
    record.raw = v7;
    append(records, record);
    append(records, record_of(empty));
    std::string_view rest = records;
    const auto first = next_record(rest), second = next_record(rest);
    ASSERT_TRUE(first && second);
    EXPECT_EQ(support::Bytes(first->raw.begin(), first->raw.end()), v7);
    EXPECT_EQ(first->direction, Direction::in);
    EXPECT_TRUE(second->raw.empty());
    EXPECT_TRUE(rest.empty());
    for (std::size_t size = 0; size < record.size(); ++size) {
        std::string_view cut = std::string_view{records}.substr(0, size);
        EXPECT_FALSE(next_record(cut)) << size;
    }
}

TEST(FrameRecord, damaged_records_are_rejected) {
    std::string records;
    append(records, record_of(euler));
    for (std::size_t size = 0; size < records.size(); ++size) {
        std::string_view cut = std::string_view{records}.substr(0, size);
        EXPECT_FALSE(next_record(cut)) << size;
        EXPECT_EQ(cut.size(), size);
    }
    std::string wrong = records;
    wrong[17] = 3;    // no direction
    std::string_view rest = wrong;
    EXPECT_FALSE(next_record(rest));
    wrong = records;
    wrong.back() ^= 1;
    rest = wrong;
    EXPECT_FALSE(next_record(rest));
}

TEST(FrameRecord, causes_are_the_counters_of_whole_frames_that_are_not_forwarded) {
    const auto causes = frame_causes();
    EXPECT_EQ(causes.front(), "");
    EXPECT_EQ((std::set<std::string_view>{causes.begin() + 1, causes.end()}),
              (std::set<std::string_view>{"denied_in", "inhibited", "looped", "duplicate", "no_route", "superseded", "queue_full",
                                          "stale", "limited", "denied_out", "link_down", "too_big", "send_failed", "held_back"}));
    EXPECT_EQ(causes[number_of(&ReceiveCounters::no_route)], "no_route");
    EXPECT_EQ(causes[number_of(&SendCounters::stale)], "stale");
    EXPECT_EQ(number_of(&SendCounters::frames_out), 0) << "is no cause";
}

}    // namespace
}    // namespace frame_record_tests
