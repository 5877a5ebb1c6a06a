// False headers, recognised by the frames received before on the line.
#include "parser_line.hpp"

using namespace parsing;

namespace parser_heard_tests {
namespace {

constexpr std::uint8_t stranger = 0x77;

// Two frames of 0xDC were received, with id 0x01 and 13 bytes of DATA.
struct HeardLine : Line {
    explicit HeardLine(FrameParser::Options options = {}) : Line{options} {
        put(numbered(100) + numbered(101));
        frames.clear();
    }
};

const Bytes pair_of_frames = numbered(1) + numbered(2);

TEST(FrameParser, delivers_two_valid_frames_in_a_row_after_a_header_from_an_unknown_sender) {
    for (const std::size_t at_once : {1u, 5u, 1000u}) {
        HeardLine line;
        line.put(header(1000, stranger) + begin_of(pair_of_frames, 41), at_once);
        EXPECT_TRUE(line.frames.empty());
        line.put(rest_of(pair_of_frames, 41));
        EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
        EXPECT_EQ(line.counters().expired, 1u);
        EXPECT_EQ(line.counters().skipped_bytes, 6u);
        EXPECT_FALSE(line.parser.deadline());
    }
}

TEST(FrameParser, delivers_two_frames_in_a_row_after_other_bytes) {
    for (const std::size_t at_once : {1u, 5u, 1000u}) {
        HeardLine line;
        line.put(header(4000, stranger) + Bytes(100) + numbered(3) + Bytes(7, ano::head) + numbered(4) + Bytes(1), at_once);
        EXPECT_TRUE(line.frames.empty());
        line.put(header(900) + pair_of_frames, at_once);
        EXPECT_EQ(line.frames, (Frames{numbered(3), numbered(4), numbered(1), numbered(2)}));
    }
}

TEST(FrameParser, delivers_two_frames_in_a_row_after_any_number_of_headers) {
    for (const std::size_t at_once : {1u, 1000u}) {
        HeardLine line;
        for (std::size_t i = 0; i < 100; ++i) line.put(header(2000 + 7 * i, i % 2 ? stranger : 0xDC), at_once);
        line.put(pair_of_frames, at_once);
        EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
        EXPECT_EQ(line.counters().expired, 100u);
    }
}

TEST(FrameParser, delivers_two_frames_in_a_row_if_false_headers_in_their_DATA_end_where_they_end) {
    const auto holding = [](const Bytes& inner) { return support::frame(0xDC, 0xFE, 0x01, inner); };
    const Bytes first = holding(header(7) + header(1) + Bytes(1));
    const Bytes second = holding(Bytes{9} + header(5) + Bytes(5));
    HeardLine line;
    line.put(header(1000, stranger) + first + second);
    EXPECT_EQ(line.frames, (Frames{first, second}));
}

// The candidate begins one byte before the two frames, and would end one byte after them: its LEN is the id of the first.
TEST(FrameParser, delivers_two_frames_that_fill_the_candidate_except_for_one_byte_at_each_end) {
    const Bytes first = support::frame(0xDC, 0xFE, 23), second = numbered(1);
    HeardLine line;
    line.put(Bytes{ano::head} + first + second);
    EXPECT_EQ(line.frames, (Frames{first, second}));
    EXPECT_EQ(line.counters().expired, 1u);
}

TEST(FrameParser, does_not_abandon_a_header_for_a_single_frame_or_two_separate_ones) {
    HeardLine line;
    line.put(header(1000, stranger) + numbered(1) + Bytes(1) + numbered(2) + Bytes(1));
    EXPECT_TRUE(line.frames.empty());
    line.pass(50ms);
    line.expire();
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
}

TEST(FrameParser, does_not_abandon_a_header_for_frames_that_are_damaged_or_from_unknown_senders) {
    Bytes damaged = numbered(2);
    damaged[10] ^= 1;
    Bytes of_wrong_add = numbered(2);    // its other check is right, so it is examined
    of_wrong_add.back() ^= 1;
    const Bytes strange = support::frame(stranger, 0xFE, 0x01, Bytes(13));
    for (const Bytes& second : {damaged, of_wrong_add, strange}) {
        HeardLine line;
        line.put(header(1000, stranger) + numbered(1) + second + Bytes(1) + second + numbered(1) + Bytes(1));
        EXPECT_TRUE(line.frames.empty());
    }
}

// Its source is known, but a bit of LEN was flipped.
TEST(FrameParser, delivers_frames_after_a_header_whose_LEN_is_larger_than_any_seen) {
    for (unsigned bit = 0; bit < 12; ++bit) {
        const std::size_t length = 13u ^ 1u << bit;
        if (length < 13) continue;
        Bytes bad = numbered(3);
        bad[4] = static_cast<std::uint8_t>(length);
        bad[5] = static_cast<std::uint8_t>(length >> 8);
        HeardLine line;
        line.put(bad + pair_of_frames);
        EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)})) << "LEN " << length;
        EXPECT_EQ(line.counters().skipped_bytes, 21u);
    }
}

TEST(FrameParser, waits_for_a_header_with_a_LEN_that_was_seen) {
    const Bytes longer = support::frame(0xDC, 0xFE, 0x01, Bytes(60));
    HeardLine line;
    line.put(header(60) + pair_of_frames);
    EXPECT_EQ(line.frames.size(), 2u);
    line.put(longer);
    line.frames.clear();
    line.put(header(60) + pair_of_frames);
    EXPECT_TRUE(line.frames.empty());
    line.put(header(61) + pair_of_frames);    // this ends the wait
    EXPECT_EQ(line.frames.size(), 4u);
}

TEST(FrameParser, waits_for_the_full_timeout_if_no_frame_was_seen) {
    Line line;
    line.put(header(1000) + numbered(1) + numbered(2) + numbered(3));
    EXPECT_TRUE(line.frames.empty());
    EXPECT_EQ(line.parser.deadline(), line.now + 50ms);
}

// After a header that gives way there may be an incomplete frame: that one waits for its rest.
TEST(FrameParser, abandons_one_candidate_at_a_time) {
    const Bytes log = support::frame(0xDC, 0xFE, 0xA0, Bytes(10) + pair_of_frames + Bytes(300));
    for (std::size_t cut = ano::overhead; cut < log.size(); ++cut) {
        HeardLine line;
        line.put(header(4000, stranger) + begin_of(log, cut));
        EXPECT_TRUE(line.frames.empty());
        line.put(rest_of(log, cut) + pair_of_frames);
        EXPECT_EQ(line.frames, (Frames{log, numbered(1), numbered(2)})) << "cut at " << cut;
    }
}

TEST(FrameParser, keeps_the_seen_sources_and_lengths_after_the_end_of_input) {
    HeardLine line;
    line.finish();
    line.feed_datagram(begin_of(numbered(3), 7));
    line.feed_datagram(header(1000, stranger) + pair_of_frames);
    line.finish();
    line.put(header(1000, stranger) + pair_of_frames);
    EXPECT_EQ(line.frames.size(), 4u);
}

// The limit for the search: examining a header, and each header that gives way, costs the credit of 32 bytes of valid frames. The
// credit is at most 65536 bytes, and begins full.
struct FloodedLine : HeardLine {
    FloodedLine() {
        const Bytes flood = header(4000, stranger) + Bytes(3994, ano::head) + Bytes(8, 0xFF);
        put(flood, 100);
        EXPECT_EQ(parser.waiting(), 0u);
    }
};

TEST(FrameParser, searches_for_two_frames_in_a_row_only_with_credit_from_valid_frames) {
    FloodedLine line;
    line.put(header(1000, stranger) + pair_of_frames + pair_of_frames);
    EXPECT_TRUE(line.frames.empty());
    line.pass(50ms);
    line.expire();
    EXPECT_EQ(line.frames.size(), 4u);
}

TEST(FrameParser, searches_for_two_frames_in_a_row_again_after_enough_valid_frames) {
    for (const unsigned good : {4u, 5u}) {    // of 21 bytes, for two examinations and a header that gives way
        FloodedLine line;
        for (unsigned i = 0; i < good; ++i) line.put(numbered(i));
        line.put(header(1000, stranger) + pair_of_frames);
        EXPECT_EQ(line.frames.size(), good == 4 ? good : good + 2);
    }
}

TEST(FrameParser, needs_credit_from_valid_frames_for_every_header_it_abandons) {
    for (const unsigned good : {7u, 8u}) {    // for three examinations and two headers that give way
        FloodedLine line;
        for (unsigned i = 0; i < good; ++i) line.put(numbered(i));
        line.put(header(1000, stranger) + header(1000, stranger) + pair_of_frames);
        EXPECT_EQ(line.frames.size(), good == 7 ? good : good + 2);
    }
}

TEST(FrameParser, finds_two_frames_in_a_row_later_in_bytes_that_it_could_not_examine_at_once) {
    FloodedLine line;
    for (unsigned i = 0; i < 2; ++i) line.put(numbered(i));    // they pay for one examination
    Bytes good;
    for (unsigned i = 2; i < 7; ++i) good = good + numbered(i);
    const Bytes behind = good + header(1000, stranger) + pair_of_frames;
    line.put(header(behind.size() - 1, stranger) + behind);
    EXPECT_EQ(line.frames.size(), 2u);
    line.put(Bytes(1));    // the first header's frame is complete, and invalid
    EXPECT_EQ(line.frames.size(), 9u);
    EXPECT_EQ(line.counters().expired, 1u);
}

TEST(FrameParser, stores_credit_from_valid_frames_up_to_a_limit) {
    HeardLine line;
    for (unsigned i = 0; i < 4000; ++i) line.put(numbered(i));
    line.frames.clear();
    line.put(header(4096, stranger) + Bytes(2046, ano::head) + Bytes(8, 0xFF), 100);    // credit for two examinations is left
    line.put(pair_of_frames);
    EXPECT_TRUE(line.frames.empty());
}

struct Outer {
    std::string name;
    std::uint8_t source;
    std::uint8_t id;
    Bytes begin;    // of DATA
};

class KnownSender : public testing::TestWithParam<Outer> {};

// The first frame of a known sender with an id of any length, and tunnel frames of any sender.
TEST_P(KnownSender, keeps_frames_inside_its_DATA) {
    const auto& [name, source, id, begin] = GetParam();
    const Bytes inner = numbered(1) + numbered(2) + numbered(3) + support::frame(0xDC, 0xFE, 0xA0, {1, 'a'});
    const Bytes outer = support::frame(source, 0xFE, id, begin + inner + Bytes{0, ano::head, 0xAA} + inner);
    for (const Bytes& before : {Bytes{}, header(4000, stranger), header(3000) + Bytes(3)}) {
        for (std::size_t cut = 0; cut <= outer.size(); ++cut) {
            for (const ano::Duration pause : {0ms, 49ms}) {
                HeardLine line{{.line_rate = 1000}};
                line.put(before + begin_of(outer, cut));
                line.pass(pause);
                line.expire();
                line.put(rest_of(outer, cut) + pair_of_frames);
                ASSERT_EQ(line.frames, (Frames{outer, numbered(1), numbered(2)})) << "cut at " << cut;
            }
        }
        // As on a line of 1200 baud, byte by byte.
        HeardLine line{{.line_rate = 120}};
        for (const std::uint8_t byte : before + outer + pair_of_frames) {
            line.put(Bytes{byte});
            line.pass(8'333us);
            line.expire();
        }
        EXPECT_EQ(line.frames, (Frames{outer, numbered(1), numbered(2)}));
    }
}

INSTANTIATE_TEST_SUITE_P(sends, KnownSender,
                         testing::Values(Outer{"a_log", 0xDC, 0xA0, {0}}, Outer{"a_log_with_a_value", 0xDC, 0xA1, Bytes(4)},
                                         Outer{"an_image", 0xDC, 0xB0, Bytes(17)}, Outer{"a_command", 0xDC, 0xC0, {1, 2, 3}},
                                         Outer{"a_command_info", 0xDC, 0xC2, Bytes(13)}, Outer{"a_value", 0xDC, 0xE1, {1, 0}},
                                         Outer{"a_parameter_info", 0xDC, 0xE2, Bytes(23)},
                                         Outer{"a_device_info", 0xDC, 0xE3, Bytes(9)},
                                         Outer{"firmware", 0xDC, 0xF0, {0x10, 0, 0}}, Outer{"flexible1", 0xDC, 0xF1, {}},
                                         Outer{"flexible10", 0xDC, 0xFA, {}}, Outer{"special", 0xDC, 0xFB, {}},
                                         Outer{"a_scan", 0xDC, 0x34, {100}}, Outer{"what_is_not_listed", 0xDC, 0x99, {}},
                                         Outer{"a_tunnel_frame", 0xDC, 0xB1, Bytes(10)},
                                         Outer{"a_strangers_tunnel_frame", stranger, 0xB1, Bytes(10)},
                                         Outer{"a_strangers_short_tunnel_frame", stranger, 0xB2, Bytes(4)}),
                         [](const auto& test) { return test.param.name; });

// The limit of the rule: a long frame of an unknown sender can't be distinguished from a false header.
TEST(FrameParser, delivers_the_inner_frames_of_an_unknown_senders_first_frame_if_it_arrives_in_parts) {
    const Bytes log = support::frame(stranger, 0xFE, 0xA0, Bytes(1) + pair_of_frames + Bytes(10));
    HeardLine whole;
    whole.put(log);
    EXPECT_EQ(whole.frames, Frames{log});
    HeardLine pieces;
    pieces.put(begin_of(log, 60));
    pieces.put(rest_of(log, 60) + log);
    EXPECT_EQ(pieces.frames, (Frames{numbered(1), numbered(2), log}));
    pieces.put(begin_of(log, 60));
    pieces.put(rest_of(log, 60));
    EXPECT_EQ(pieces.frames.back(), log);
}

}    // namespace
}    // namespace parser_heard_tests
