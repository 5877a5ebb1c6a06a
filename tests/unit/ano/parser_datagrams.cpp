#include "parser_line.hpp"

using namespace parsing;

namespace parser_datagrams_tests {
namespace {

TEST(FrameParser, continues_a_partial_frame_of_the_previous_datagram) {
    Line line;
    line.feed_datagram(numbered(1) + begin_of(numbered(2), 7));
    line.pass(99ms);
    line.feed_datagram(rest_of(numbered(2), 7) + numbered(3));
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2), numbered(3)}));
    EXPECT_EQ(line.counters().skipped_bytes, 0u);
}

TEST(FrameParser, abandons_a_partial_frame_of_a_datagram_after_100_ms) {
    Line line;
    line.feed_datagram(begin_of(numbered(2), 7));
    line.pass(100ms);
    line.feed_datagram(rest_of(numbered(2), 7) + numbered(3));
    EXPECT_EQ(line.frames, Frames{numbered(3)});
    EXPECT_EQ(line.counters().expired, 1u);
}

TEST(FrameParser, abandons_a_partial_frame_when_a_datagram_starts_with_a_complete_valid_frame) {
    Line line;
    line.feed_datagram(begin_of(numbered(1), 7));
    line.feed_datagram(numbered(2) + begin_of(numbered(3), 7));
    EXPECT_EQ(line.frames, Frames{numbered(2)});
    EXPECT_EQ(line.counters().skipped_bytes, 7u);
    line.feed_datagram(rest_of(numbered(3), 7));
    EXPECT_EQ(line.frames, (Frames{numbered(2), numbered(3)}));
}

TEST(FrameParser, keeps_a_partial_frame_when_a_datagram_starts_with_a_frame_larger_than_max_data) {
    // The rest of the outer frame is the beginning of an inner one that is valid, but too large.
    Line line{{.max_data = 40}};
    const Bytes outer = support::frame(1, 2, 3, Bytes(10) + header(41) + Bytes(24));
    Bytes datagram = rest_of(outer, 16);
    datagram.resize(ano::overhead + 41);
    ano::seal(datagram);
    ASSERT_TRUE(ano::frame_at(datagram));
    line.feed_datagram(begin_of(outer, 16));
    line.feed_datagram(datagram);
    EXPECT_EQ(line.frames, Frames{outer});
}

TEST(FrameParser, finds_the_frames_inside_an_abandoned_partial_frame) {
    const Tunnel tunnel;
    for (const ano::Duration pause : {ano::Duration{1ms}, ano::Duration{100ms}}) {
        Line line;
        line.feed_datagram(begin_of(tunnel.whole, tunnel.cut));
        EXPECT_TRUE(line.frames.empty());
        line.pass(pause);
        line.feed_datagram(numbered(3));
        EXPECT_EQ(line.frames, (Frames{tunnel.first, tunnel.second, numbered(3)}));
    }
}

TEST(FrameParser, does_not_join_a_candidate_inside_an_abandoned_partial_frame_with_the_next_datagram) {
    Line line;
    line.feed_datagram(header(200) + begin_of(numbered(1), 10));
    line.pass(100ms);
    line.feed_datagram(rest_of(numbered(1), 10) + numbered(2));
    EXPECT_EQ(line.frames, Frames{numbered(2)});
    EXPECT_EQ(line.counters().expired, 2u);
}

TEST(FrameParser, parses_a_datagram_larger_than_its_buffer_in_parts) {
    Line line{{.max_data = 20}};
    Frames sent;
    Bytes datagram;
    for (unsigned i = 0; datagram.size() < 60000; ++i) datagram = datagram + sent.emplace_back(numbered(i));
    line.feed_datagram(begin_of(numbered(9999), 15));
    ASSERT_LT(line.parser.prepare().size(), datagram.size());
    line.feed_datagram(datagram);
    EXPECT_EQ(line.frames, sent);
    EXPECT_EQ(line.counters().skipped_bytes, 15u);
}

TEST(FrameParser, parses_a_datagram_of_60_frames) {
    Frames sent;
    Bytes datagram;
    for (unsigned i = 0; i < 60; ++i) datagram = datagram + sent.emplace_back(numbered(i));
    Line line;
    for (int i = 0; i < 5; ++i) {
        line.frames.clear();
        line.feed_datagram(datagram);
        EXPECT_EQ(line.frames, sent);
    }
}

TEST(FrameParser, ignores_an_empty_datagram) {
    Line line;
    line.feed_datagram({});
    line.feed_datagram(begin_of(numbered(1), 7));
    line.feed_datagram({});
    line.feed_datagram(rest_of(numbered(1), 7));
    EXPECT_EQ(line.frames, Frames{numbered(1)});
}

}    // namespace
}    // namespace parser_datagrams_tests
