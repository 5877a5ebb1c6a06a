#include <record/recording_counts.hpp>

#include <gtest/gtest.h>

#include <string>

#include <support/bytes.hpp>

namespace recording_counts_tests {
namespace {

using namespace anogate;

const auto euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
const auto wind = support::frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});

RecordingCounts some() {
    RecordingCounts counts;
    RecordedFrame frame{.time_ns = 5'000'000'000, .boottime_ns = 1'000'000'000, .link = "fc", .frame = ano::FrameView{euler}};
    frame.link_description = "serial";
    counts.add(frame);
    counts.add(RecordedLoss{7, "euler 4, power 3"});
    counts.add(RecordedLoss{1, "power 1"});
    frame.time_ns = 2'000'000'000;    // the clock was set back by 5 s
    frame.boottime_ns = 3'000'000'000;
    frame.direction = Direction::dropped;
    frame.cause = "limited";
    frame.frame = ano::FrameView{wind};
    counts.add(frame);
    return counts;
}

TEST(RecordingCounts, add_up_the_content_of_a_recording) {
    const RecordingCounts counts = some();
    EXPECT_EQ(counts.frames, 2u);
    EXPECT_EQ(counts.bytes, euler.size() + wind.size());
    EXPECT_EQ(counts.lost, 8u);
    EXPECT_EQ(counts.lost_messages, (std::map<std::string, std::uint64_t>{{"euler", 4}, {"power", 4}}));
    EXPECT_EQ(counts.seconds(), 2.0);
    EXPECT_EQ(counts.clock_was_set(), -5.0);
    EXPECT_EQ(counts.rate(4), 2.0);
    EXPECT_EQ(counts.links.at("fc").frames, (std::array<std::uint64_t, 3>{1, 0, 1}));
    EXPECT_EQ(counts.links.at("fc").causes.at("limited"), 1u);
    EXPECT_TRUE(counts.messages[0x09].from[0xDD]);
}

TEST(RecordingCounts, their_json_keeps_everything) {
    EXPECT_EQ(RecordingCounts::of_json(some().json()), some());
    EXPECT_EQ(RecordingCounts::of_json(RecordingCounts{}.json()), RecordingCounts{});
}

TEST(RecordingCounts, reject_invalid_json) {
    const std::string good = some().json();
    for (const char* text : {"", "{}", "[]", "{\"frames\": -1}", "nonsense"})
        EXPECT_FALSE(RecordingCounts::of_json(text)) << text;
    EXPECT_FALSE(RecordingCounts::of_json(good.substr(0, good.size() - 1)));
    const auto with = [&](std::string_view what, std::string_view instead) {
        std::string text = good;
        return RecordingCounts::of_json(text.replace(text.find(what), what.size(), instead));
    };
    EXPECT_FALSE(with("\"id\":3", "\"id\":256"));
    EXPECT_FALSE(with("\"from\":[220]", "\"from\":[256]"));
    EXPECT_FALSE(with("\"kind\":\"serial\"", "\"kind\":1"));
}

}    // namespace
}    // namespace recording_counts_tests
