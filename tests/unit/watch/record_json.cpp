#include <watch/record_json.hpp>

#include <ano_json/frame_json.hpp>
#include <support/bytes.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <variant>

namespace record_json_tests {

using namespace anogate;
using nlohmann::json;
using support::frame;

namespace {

const WatchTables tables{{"fc", "", "ground"}, {"/dev/ttyUSB0", "\xFFpeer"}, {}, ""};
const auto euler = frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
constexpr std::uint64_t time_ns = 1'700'000'000'123'456'789;

json shown(const FrameRecord& record) { return json::parse(record_json(record, tables, {})); }

TEST(RecordJson, contains_the_frame_with_the_time_and_link_where_it_passed) {
    const json in = shown({time_ns, 5, 0, Direction::in, 0, 0, ano::FrameView{euler}});
    EXPECT_EQ(in.at("name"), "euler");
    EXPECT_EQ(in.at("fields").at("rol"), 1.23);
    EXPECT_EQ(in.at("time"), 1700000000.123456);
    EXPECT_EQ(in.at("link"), "fc");
    EXPECT_EQ(in.at("peer"), "/dev/ttyUSB0");
    EXPECT_EQ(in.at("direction"), "in");
    EXPECT_FALSE(in.contains("cause"));
    EXPECT_FALSE(in.contains("elsewhere"));
    EXPECT_EQ(shown({time_ns, 5, 0, Direction::in, 0, 0, ano::FrameView{euler}, true}).at("elsewhere"), true);
    const auto bytes = ano::frame_from_json(ano::Json::parse(in.dump()));
    ASSERT_TRUE(std::holds_alternative<std::vector<std::uint8_t>>(bytes)) << std::get<ano::JsonFault>(bytes).what;
    EXPECT_EQ(std::get<0>(bytes), euler) << "what is told beside it is ignored where a frame is made of it";
}

TEST(RecordJson, contains_the_cause_of_a_drop_and_no_channel_where_there_is_none) {
    const json dropped = shown(
        {time_ns, 5, 2, Direction::dropped, number_of(&SendCounters::limited), FrameRecord::no_channel, ano::FrameView{euler}});
    EXPECT_EQ(dropped.at("link"), "ground");
    EXPECT_EQ(dropped.at("direction"), "dropped");
    EXPECT_EQ(dropped.at("cause"), "limited");
    EXPECT_FALSE(dropped.contains("peer"));
}

TEST(RecordJson, unknown_numbers_are_null_and_invalid_text_is_replaced) {
    EXPECT_EQ(shown({0, 0, 1, Direction::in, 0, 7, ano::FrameView{euler}}).at("link"), nullptr);
    EXPECT_EQ(shown({0, 0, 9, Direction::in, 0, 7, ano::FrameView{euler}}).at("peer"), nullptr);
    EXPECT_EQ(shown({0, 0, 0, Direction::in, 0, 1, ano::FrameView{euler}}).at("peer"), "\xEF\xBF\xBDpeer");
}

TEST(RecordJson, lost_frames_are_reported_per_message) {
    LostFrames lost;
    lost.by_id[0x03] = 120;
    lost.by_id[0x77] = 2;
    lost.since = std::chrono::milliseconds{500};
    EXPECT_EQ(lost_json(lost), R"({"lost":{"euler":120,"0x77":2},"since_ms":500})");
}

TEST(RecordJson, tables_name_the_numbers) {
    const json all = json::parse(tables_json(tables));
    EXPECT_EQ(all.at("links"), (json{"fc", nullptr, "ground"}));
    EXPECT_EQ(all.at("channels"), (json{"/dev/ttyUSB0", "\xEF\xBF\xBDpeer"}));
    EXPECT_EQ(all.at("causes").at(0), nullptr);
    EXPECT_EQ(all.at("causes").size(), frame_causes().size());
    EXPECT_EQ(all.at("decoding"), json::object());
}

}    // namespace
}    // namespace record_json_tests
