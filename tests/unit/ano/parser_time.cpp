#include "parser_line.hpp"

using namespace parsing;

namespace parser_time_tests {
namespace {

TEST(FrameParser, has_no_deadline_while_no_candidate_is_waiting) {
    Line line;
    EXPECT_FALSE(line.parser.deadline());
    line.put(numbered(1) + Bytes{1, 2, 3});
    EXPECT_FALSE(line.parser.deadline());
    line.pass(1h);
    EXPECT_FALSE(line.parser.expire(line.now));
}

TEST(FrameParser, delivers_valid_frames_after_a_false_header_once_the_line_is_quiet) {
    Line line;
    line.put(header(1000) + numbered(1) + numbered(2));
    EXPECT_EQ(line.parser.deadline(), line.now + 50ms);
    line.pass(49ms);
    EXPECT_FALSE(line.parser.expire(line.now));
    EXPECT_TRUE(line.frames.empty());
    line.pass(1ms);
    line.expire();
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
    EXPECT_FALSE(line.parser.deadline());
}

TEST(FrameParser, restarts_the_quiet_time_with_every_received_byte) {
    Line line;
    line.put(header(1000) + numbered(1));
    for (int i = 0; i < 10; ++i) {
        line.pass(40ms);
        line.expire();
        line.put(Bytes{0});
        EXPECT_EQ(line.parser.deadline(), line.now + 50ms);
    }
    EXPECT_TRUE(line.frames.empty());
}

TEST(FrameParser, uses_the_configured_quiet_time) {
    Line line{{.quiet = 100ms}};
    line.put(header(1000) + numbered(1));
    EXPECT_EQ(line.parser.deadline(), line.now + 100ms);
    line.pass(99ms);
    EXPECT_FALSE(line.parser.expire(line.now));
    line.pass(1ms);
    EXPECT_TRUE(line.parser.expire(line.now));
}

TEST(FrameParser, accepts_a_valid_frame_that_arrives_slowly_in_pieces) {
    Line line;
    const Bytes frame = support::frame(1, 2, 3, Bytes(300, ano::head));
    for (std::size_t i = 0; i < 10; ++i) {
        line.put(begin_of(rest_of(frame, 30 * i), 30));
        line.pass(90ms);
        line.expire();
        EXPECT_EQ(line.parser.waiting(), 30 * (i + 1));
    }
    line.put(rest_of(frame, 300));
    EXPECT_EQ(line.frames, Frames{frame});
}

TEST(FrameParser, expires_an_overdue_candidate_after_one_second_if_the_line_rate_is_unknown) {
    Line line;
    line.put(header(1000) + Bytes(10));
    const auto began = line.now;
    line.pass(400ms);
    line.put(Bytes(10));
    line.pass(50ms);
    EXPECT_FALSE(line.parser.expire(line.now));
    EXPECT_EQ(line.parser.deadline(), began + 1s);
    line.now = began + 1s - 1ns;
    EXPECT_FALSE(line.parser.expire(line.now));
    line.now = began + 1s;
    line.expire();
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_EQ(line.counters().expired, 1u);
    EXPECT_EQ(line.counters().skipped_bytes, 26u);
}

TEST(FrameParser, expires_an_overdue_candidate_according_to_a_known_line_rate) {
    Line line{{.line_rate = 1000}};
    line.put(header(92) + Bytes(10));
    const auto began = line.now;
    line.pass(50ms);
    EXPECT_FALSE(line.parser.expire(line.now));
    EXPECT_EQ(line.parser.deadline(), began + 200ms + 100ms);
    line.parser.set_line_rate(100);
    EXPECT_EQ(line.parser.deadline(), began + 200ms + 1s);
    line.now = began + 1200ms;
    line.expire();
    EXPECT_EQ(line.parser.waiting(), 0u);
}

TEST(FrameParser, stops_waiting_for_the_rest_of_a_header_after_a_timeout) {
    Line line{{.line_rate = 1000}};
    line.put(Bytes{ano::head});
    EXPECT_EQ(line.parser.deadline(), line.now + 50ms);
    line.pass(208ms);
    line.expire();
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_FALSE(line.parser.deadline());
}

TEST(FrameParser, expires_thousands_of_overdue_candidates_in_one_step) {
    Line line{{.max_data = 65535}};
    line.put(Bytes(43000, ano::head));
    line.pass(50ms);
    EXPECT_FALSE(line.parser.expire(line.now));
    line.pass(4800ms);    // 1 s and the time of 0xABAB bytes at 115200 baud
    EXPECT_TRUE(line.parser.expire(line.now));
    EXPECT_FALSE(line.parser.next());
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_EQ(line.counters().expired, 43000u);
}

TEST(FrameParser, expires_an_overdue_candidate_without_dropping_a_frame_that_is_still_arriving) {
    Line line;
    const Tunnel tunnel;
    line.put(header(4000));
    line.pass(900ms);
    line.put(begin_of(tunnel.whole, tunnel.cut));
    line.pass(20ms);
    line.put(begin_of(rest_of(tunnel.whole, tunnel.cut), 2));
    line.pass(40ms);
    line.put(begin_of(rest_of(tunnel.whole, tunnel.cut + 2), 2));
    line.pass(40ms);    // the false header is overdue, the frame behind it is not
    line.expire();
    EXPECT_TRUE(line.frames.empty());
    line.put(rest_of(tunnel.whole, tunnel.cut + 4));
    EXPECT_EQ(line.frames, Frames{tunnel.whole});
}

TEST(FrameParser, delivers_a_candidate_that_is_completed_after_the_search_went_past_it) {
    Line line;
    const Bytes frame = support::frame(1, 2, 3, header(500) + Bytes(200, 0x21) + header(600) + Bytes(400, 7));
    line.put(begin_of(frame, 500));
    line.pass(60ms);
    line.expire();
    line.put(rest_of(frame, 500) + numbered(1));
    EXPECT_EQ(line.frames, (Frames{frame, numbered(1)}));
}

TEST(FrameParser, delivers_all_waiting_frames_at_the_end_of_input) {
    Line line;
    line.put(header(4000) + numbered(1) + header(50) + numbered(2) + Bytes{ano::head});
    EXPECT_TRUE(line.frames.empty());
    line.finish();
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_FALSE(line.parser.deadline());
    line.put(numbered(3));
    EXPECT_EQ(line.frames.back(), numbered(3));
}

TEST(FrameParser, does_not_join_a_frame_across_the_end_of_input) {
    Line line;
    line.put(begin_of(numbered(1), 10));
    line.finish();
    line.put(rest_of(numbered(1), 10) + numbered(2));
    EXPECT_EQ(line.frames, Frames{numbered(2)});
}

// A radio that sends a frame in packets: pauses inside a frame are normal there, and a frame waits while its bytes still arrive.
TEST(FrameParser, allows_pauses_up_to_the_frame_gap_on_fast_lines_and_between_datagrams) {
    const Bytes frame = support::frame(0xDC, 2, 3, Bytes(40) + numbered(7) + Bytes(40));
    for (const bool datagrams : {false, true})
        for (const auto pause : {390ms, 410ms}) {
            Line line{{.line_rate = 50'000, .frame_gap = 400ms}};
            for (std::size_t i = 0; i < frame.size(); i += 20) {
                const Bytes piece = begin_of(rest_of(frame, i), std::min<std::size_t>(20, frame.size() - i));
                datagrams ? line.feed_datagram(piece) : line.put(piece);
                line.pass(50ms);
                line.expire();
                EXPECT_EQ(line.parser.deadline().value_or(line.now + 350ms), line.now + 350ms);
                line.pass(pause - 50ms);
                line.expire();
            }
            EXPECT_EQ(line.frames, pause < 400ms ? Frames{frame} : Frames{});
        }
}

// The rest of the frame at the beginning was lost; the line never pauses for the frame gap.
TEST(FrameParser, delivers_each_frame_after_a_false_header_as_soon_as_it_is_followed_by_a_pause_despite_the_frame_gap) {
    for (const bool datagrams : {false, true}) {
        Line line{{.line_rate = 11'520, .frame_gap = 500ms}};
        const auto put = [&](const Bytes& bytes) { datagrams ? line.feed_datagram(bytes) : line.put(bytes); };
        put(header(601) + Bytes(14));
        for (std::uint8_t i = 0; i < 10; ++i) {
            line.pass(400ms);
            line.expire();
            put(numbered(i));
            line.pass(50ms);
            line.expire();
            EXPECT_EQ(line.frames.size(), i + 1u);
        }
    }
}

TEST(FrameParser, gives_up_a_false_header_on_a_line_without_pauses_despite_the_frame_gap) {
    Line line{{.line_rate = 11'520, .frame_gap = 500ms}};
    line.put(header(4000));
    const ano::TimePoint begin = line.now;
    while (line.frames.empty() && line.now - begin < 1min) {
        line.pass(40ms);
        line.expire();
        line.put(numbered(1));
    }
    EXPECT_LT(line.now - begin, 200ms + 350ms + 100ms) << "the time for 4000 bytes";
    EXPECT_GT(line.frames.size(), 10u);
}

// A camera behind a serial port server, whose connection shows no rate.
TEST(FrameParser, waits_for_an_image_at_115200_baud_if_the_rate_is_unknown) {
    Line line;
    Bytes data(19'217);
    const Bytes head{0, 120, 0, 160, 0};    // color, width, height
    std::copy(head.begin(), head.end(), data.begin() + 2);
    const Bytes frame = support::frame(0xDC, 0xFE, 0xB0, data);
    for (std::size_t i = 0; i < frame.size(); i += 115) {
        line.put(begin_of(rest_of(frame, i), std::min<std::size_t>(115, frame.size() - i)));
        line.pass(10ms);
        line.expire();
    }
    EXPECT_EQ(line.frames, Frames{frame});
}

// A camera behind a bridge that sends 512 bytes at a time.
TEST(FrameParser, waits_for_all_pauses_of_a_long_frame) {
    Line line{{.max_data = 20'000, .line_rate = 50'000, .frame_gap = 300ms}};
    const Bytes frame = support::frame(0xDC, 2, 3, Bytes(19'000, 7));
    for (std::size_t i = 0; i < frame.size(); i += 512) {
        line.put(begin_of(rest_of(frame, i), std::min<std::size_t>(512, frame.size() - i)));
        for (const auto pause : {50ms, 200ms}) {
            line.pass(pause);
            line.expire();
        }
    }
    EXPECT_EQ(line.frames, Frames{frame});
}

}    // namespace
}    // namespace parser_time_tests
