#include "parser_line.hpp"

using namespace parsing;

namespace parser_previous_version_tests {
namespace {

TEST(FrameParser, detects_frames_of_the_previous_version_however_they_are_split) {
    const Bytes one = v7_frame(0x03, {1, 2, 3, 4, 5, 6, 0xAB});
    for (std::size_t at_once = 1; at_once < 2 * one.size(); ++at_once) {
        Line line;
        for (int i = 0; i < 10; ++i) line.put(one, at_once);
        line.finish();
        EXPECT_EQ(line.counters().v7_frames, 10u) << "by " << at_once;
        EXPECT_TRUE(line.frames.empty());
    }
}

TEST(FrameParser, detects_no_frame_of_the_previous_version_with_a_wrong_checksum) {
    for (const std::size_t back : {1u, 2u}) {
        Bytes bad = v7_frame(0x03, {1, 2, 3});
        bad[bad.size() - back] ^= 1;
        Line line;
        line.put(bad + bad);
        EXPECT_EQ(line.counters().v7_frames, 0u);
        line.put(v7_frame(0x20, {}));
        EXPECT_EQ(line.counters().v7_frames, 1u);
    }
}

TEST(FrameParser, detects_no_frame_of_the_previous_version_in_the_data_of_a_valid_frame) {
    Line line;
    for (int i = 0; i < 10; ++i) line.put(support::frame(1, 2, 3, v7_frame(0x03, {1, 2, 3})));
    EXPECT_EQ(line.counters().v7_frames, 0u);
}

TEST(FrameParser, detects_no_frame_of_the_previous_version_around_a_valid_frame) {
    const Bytes one = v7_frame(0x03, {1, 2, 3, 4, 5, 6});
    for (std::size_t cut = 1; cut < one.size(); ++cut) {
        Line line;
        line.put(begin_of(one, cut) + numbered(1) + rest_of(one, cut));
        EXPECT_EQ(line.frames, Frames{numbered(1)});
        EXPECT_EQ(line.counters().v7_frames, 0u) << cut;
    }
}

// Crafted input must not become more expensive through the second search.
TEST(FrameParser, looks_for_the_previous_version_only_in_the_first_bytes_of_a_long_piece) {
    const Bytes one = v7_frame(0x03, {1, 2, 3, 4, 5, 6});
    Line line;
    line.put(Bytes(1000, 0x11) + one);
    EXPECT_EQ(line.counters().v7_frames, 0u);
    line.put(Bytes(60, 0x11) + begin_of(one, 4) + Bytes(1000, 0x11));
    line.put(rest_of(one, 4));
    EXPECT_EQ(line.counters().v7_frames, 0u) << "what was not looked at stood between";
    line.put(one);
    EXPECT_EQ(line.counters().v7_frames, 1u);
}

}    // namespace
}    // namespace parser_previous_version_tests
