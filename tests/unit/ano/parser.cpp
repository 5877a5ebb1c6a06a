#include <ano/parser.hpp>
#include <support/allocations.hpp>
#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

using namespace std::chrono_literals;
using ano::FrameParser;
using ano::TimePoint;
using support::Bytes;

namespace {

using Frames = std::vector<Bytes>;

// Puts bytes in, takes whole frames out, and checks that every byte is counted.
class Line {
public:
    explicit Line(FrameParser::Options options = {}) : parser{options} {}

    FrameParser parser;
    TimePoint now{};
    Frames frames;

    void put(std::span<const std::uint8_t> bytes, std::size_t at_once = SIZE_MAX) {
        while (!bytes.empty()) {
            const auto room = parser.prepare();
            ASSERT_FALSE(room.empty());
            const std::size_t n = std::min({room.size(), bytes.size(), at_once});
            std::copy_n(bytes.data(), n, room.data());
            parser.commit(n, now);
            bytes = bytes.subspan(n);
            take();
        }
    }
    void put_datagram(const Bytes& bytes, std::size_t at_once = SIZE_MAX) {
        parser.begin_datagram(bytes, now);
        take();
        put(bytes, at_once);
    }
    // Gives up all candidates that can be given up now.
    void expire() {
        while (parser.expire(now)) take();
    }
    void finish() {
        parser.finish();
        take();
    }
    void pass(ano::Duration time) { now += time; }
    const ano::ParserCounters& counters() const { return parser.counters(); }

private:
    void take() {
        while (const auto frame = parser.next()) {
            frames.emplace_back(frame->bytes().begin(), frame->bytes().end());
            good_bytes_ += frame->bytes().size();
            conserve();
        }
        conserve();
    }
    void conserve() {
        const auto& c = parser.counters();
        ASSERT_EQ(c.bytes_in, good_bytes_ + c.skipped_bytes + parser.waiting());
    }
    std::uint64_t good_bytes_ = 0;
};

Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

// A frame of 21 bytes that differs from others by `n`.
Bytes numbered(unsigned n) {
    Bytes data(13, 0x11);
    data[0] = static_cast<std::uint8_t>(n);
    data[1] = static_cast<std::uint8_t>(n >> 8);
    return support::frame(0xDC, 0xFE, 0x01, data);
}

Bytes header(std::size_t length, std::uint8_t source = 0xDC, std::uint8_t id = 0x01) {
    return {ano::head, source, 0xFE, id, static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(length >> 8)};
}

Bytes begin_of(const Bytes& bytes, std::size_t n) { return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n)}; }
Bytes rest_of(const Bytes& bytes, std::size_t n) { return {bytes.begin() + static_cast<std::ptrdiff_t>(n), bytes.end()}; }

// The beginning of a frame that carries two frames, up to behind both inner frames: as much as a datagram may hold.
struct Tunnel {
    Bytes first = numbered(1);
    Bytes second = numbered(2);
    Bytes whole = support::frame(0xDC, 0xFE, 0xB1, Bytes(10) + first + second + Bytes(10));
    std::size_t cut = ano::header_size + 10 + 42 + 2;
};

// --- What a frame is

TEST(FrameParser, passes_the_vendors_bytes_unchanged) {
    const Frames vendor{
        {0xAB, 0xFE, 0xFF, 0xE0, 0x03, 0x00, 0x00, 0x00, 0x00, 0x8B, 0x3B},
        {0xAB, 0xDB, 0xFE, 0xE3, 0x0F, 0x00, 0xDB, 0x64, 0x00, 0x64, 0x00, 0x00,
         0x00, 0x20, 0x03, 0x41, 0x6E, 0x6F, 0x4D, 0x43, 0x55, 0x3F, 0x2E},
        {0xAB, 0xFE, 0xDB, 0xE1, 0x03, 0x00, 0x00, 0x00, 0xFA, 0x62, 0x3F},
        {0xAB, 0xDB, 0xFE, 0x00, 0x03, 0x00, 0xE1, 0x62, 0x3F, 0x09, 0x82},
        {0xAB, 0xFE, 0xBA, 0xC0, 0x0B, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x2F, 0x3B}};
    Line line;
    for (const auto& frame : vendor) line.put(frame);
    EXPECT_EQ(line.frames, vendor);
    EXPECT_EQ(line.counters().skipped_bytes, 0u);
}

TEST(FrameParser, finds_frames_however_they_are_cut) {
    const Frames sent{numbered(1), support::frame(1, 2, 3), support::frame(1, 2, 3, Bytes(5, ano::head)), numbered(2)};
    Bytes all;
    for (const auto& frame : sent) all = all + frame;
    for (std::size_t at_once = 1; at_once <= all.size(); ++at_once) {
        Line line;
        line.put(all, at_once);
        EXPECT_EQ(line.frames, sent) << "by " << at_once;
    }
    for (std::size_t cut = 0; cut <= all.size(); ++cut) {
        Line line;
        line.put(begin_of(all, cut));
        line.put(rest_of(all, cut));
        EXPECT_EQ(line.frames, sent) << "cut at " << cut;
    }
}

TEST(FrameParser, accepts_no_data_at_all) {
    Line line{{.max_data = 0}};
    line.put(support::frame(1, 2, 3) + support::frame(1, 2, 3, {0}) + support::frame(4, 5, 6));
    EXPECT_EQ(line.frames, (Frames{support::frame(1, 2, 3), support::frame(4, 5, 6)}));
    EXPECT_EQ(line.counters().bad_length, 1u);
}

TEST(FrameParser, accepts_the_largest_frames_one_behind_the_other) {
    Line line{{.max_data = 65535}};
    const Bytes largest = support::frame(1, 2, 0xB0, Bytes(65535, 0x5A));
    for (int i = 0; i < 5; ++i) {
        line.put(Bytes(static_cast<std::size_t>(i)));    // so that they begin anywhere in the buffer
        line.put(largest, 3000);
    }
    EXPECT_EQ(line.frames, Frames(5, largest));
    EXPECT_EQ(line.counters().skipped_bytes, 10u);
}

TEST(FrameParser, refuses_more_than_max_data_from_the_header_alone) {
    Line line{{.max_data = 20}};
    line.put(header(21));
    EXPECT_EQ(line.counters().bad_length, 1u);
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_FALSE(line.parser.deadline());
    line.put(header(20));
    EXPECT_EQ(line.counters().bad_length, 1u);
    EXPECT_EQ(line.parser.waiting(), 6u);
    EXPECT_TRUE(std::ranges::equal(line.parser.rest(), header(20)));
}

TEST(FrameParser, keeps_a_max_data_that_LEN_cannot_say_within_what_it_can) {
    Line line{{.max_data = SIZE_MAX}};
    const Bytes largest = support::frame(1, 2, 0xB0, Bytes(65535, 0x5A));
    line.put(largest);
    EXPECT_EQ(line.frames, Frames{largest});
}

TEST(FrameParser, gives_views_that_last_until_the_next_prepare) {
    FrameParser parser{{}};
    const Bytes two = numbered(1) + numbered(2);
    std::ranges::copy(two, parser.prepare().data());
    parser.commit(two.size(), {});
    const auto first = parser.next();
    const auto second = parser.next();
    EXPECT_FALSE(parser.next());
    ASSERT_TRUE(first && second);
    EXPECT_TRUE(std::ranges::equal(first->bytes(), numbered(1)));
    EXPECT_TRUE(std::ranges::equal(second->bytes(), numbered(2)));
}

// --- Resynchronisation

TEST(FrameParser, looks_again_one_byte_after_a_refused_candidate) {
    // The good frame begins at the second byte of the bad one, whose check would reach into it.
    Line line{{.max_data = 20}};
    line.put(Bytes{ano::head} + numbered(1));
    line.put(Bytes{ano::head, ano::head, ano::head} + numbered(2));
    line.finish();
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
    EXPECT_EQ(line.counters().skipped_bytes, 4u);
}

TEST(FrameParser, finds_a_good_frame_inside_a_bad_one) {
    for (const std::size_t before : {0u, 1u, 7u, 100u}) {
        Bytes bad = support::frame(1, 2, 3, Bytes(before) + numbered(1) + numbered(2) + Bytes(9));
        bad.back() ^= 1;
        Line line;
        line.put(bad + numbered(3));
        EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2), numbered(3)}));
        EXPECT_EQ(line.counters().bad_check, 1u);
        EXPECT_EQ(line.counters().skipped_bytes, bad.size() - 42);
    }
}

TEST(FrameParser, finds_a_good_frame_behind_many_candidates_that_overlap) {
    // All of them reach over the good frame; the last one reaches into the bytes behind it.
    Bytes bytes;
    for (std::size_t i = 0; i < 40; ++i) bytes = bytes + header(300 - 6 * i + i % 5);
    const Bytes more = Bytes(200, 0x33) + numbered(2);
    for (const std::size_t at_once : {1u, 50u, 1000u}) {
        Line line;
        line.put(bytes + numbered(1) + more, at_once);
        EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
        EXPECT_EQ(line.counters().bad_check, 40u);
    }
}

TEST(FrameParser, takes_the_largest_frame_behind_a_refused_one) {
    constexpr std::size_t max_data = 100;
    Bytes refused = numbered(1);
    ++refused.back();
    for (const std::size_t before : {0u, 1u, 50u, 200u}) {
        const Bytes largest = support::frame(1, 2, 0xB0, Bytes(max_data, 0x5A));
        Line line{{.max_data = max_data}};
        line.put(refused + Bytes(before, 0x33) + largest + numbered(2));
        EXPECT_EQ(line.frames, (Frames{largest, numbered(2)})) << before;
        EXPECT_EQ(line.counters().bad_length, 0u) << before;
    }
}

TEST(FrameParser, finds_a_frame_among_heads_however_near_its_end_it_is_cut) {
    constexpr std::size_t length_of_heads = 0xABAB;
    const Bytes heads(300, ano::head);
    for (const Bytes& frame : {support::frame(1, 2, 3, Bytes(200, ano::head)),
                               support::frame(ano::head, ano::head, ano::head, Bytes(length_of_heads, 0x11))}) {
        const Bytes bytes = heads + frame;
        for (std::size_t missing = 1; missing <= 70; ++missing) {
            Line line{{.max_data = 65535}};
            line.put(begin_of(bytes, bytes.size() - missing));
            EXPECT_TRUE(line.frames.empty()) << missing;
            line.put(rest_of(bytes, bytes.size() - missing));
            line.finish();
            EXPECT_EQ(line.frames, Frames{frame}) << missing << " bytes came later";
        }
    }
}

// Candidates whose LEN is two HEADs are refused 64 at a time, as far as sums are at hand: the good one may be any of these.
TEST(FrameParser, finds_a_frame_among_heads_wherever_it_begins) {
    const Bytes frame = support::frame(ano::head, ano::head, ano::head, Bytes(0xABAB, 0x11));
    for (std::size_t heads = 990; heads < 1060; ++heads) {
        Line line{{.max_data = 65535}};
        line.put(Bytes(heads, ano::head) + frame + Bytes(3000, 0x33));
        line.finish();
        EXPECT_EQ(line.frames, Frames{frame}) << heads;
    }
}

TEST(FrameParser, loses_none_of_8_good_frames_behind_a_false_header_80_times) {
    for (const std::size_t at_once : {1u, 10u, 64u, 4096u}) {
        Line line;
        Frames sent;
        for (unsigned i = 0; i < 80; ++i) {
            line.put(header(255), at_once);
            for (unsigned k = 0; k < 8; ++k) {
                sent.push_back(numbered(8 * i + k));
                line.put(sent.back(), at_once);
            }
        }
        line.pass(50ms);
        line.expire();
        EXPECT_EQ(line.frames, sent);
        EXPECT_EQ(line.counters().bad_check + line.counters().expired, 80u);
    }
}

TEST(FrameParser, loses_none_of_80_good_frames_in_10_groups_with_a_pause_behind_each) {
    Line line;
    Frames sent;
    for (unsigned i = 0; i < 10; ++i) {
        Bytes group = header(255, 0xDC, 0xA0);
        for (unsigned k = 0; k < 8; ++k) {
            sent.push_back(numbered(8 * i + k));
            group = group + sent.back();
        }
        line.put(group);
        EXPECT_EQ(line.frames.size(), 8 * i);
        line.pass(50ms);
        line.expire();
        EXPECT_EQ(line.frames, sent);
    }
    EXPECT_EQ(line.counters().expired, 10u);
    EXPECT_EQ(line.counters().skipped_bytes, 60u);
}

TEST(FrameParser, counts_each_cause) {
    Line line{{.max_data = 100}};
    Bytes bad = numbered(1);
    bad[10] ^= 1;
    line.put(bad + Bytes{1, 2, 3} + header(101) + numbered(2) + header(50));
    EXPECT_EQ(line.parser.waiting(), 6u);
    line.finish();
    const auto& c = line.counters();
    EXPECT_EQ(c.bytes_in, 21u + 3 + 6 + 21 + 6);
    EXPECT_EQ(c.frames_in, 1u);
    EXPECT_EQ(c.bad_check, 1u);
    EXPECT_EQ(c.bad_length, 1u);
    EXPECT_EQ(c.expired, 1u);
    EXPECT_EQ(c.skipped_bytes, 36u);
    EXPECT_EQ(c.v7_frames, 0u);
}

// --- Time

TEST(FrameParser, has_no_deadline_while_nothing_waits) {
    Line line;
    EXPECT_FALSE(line.parser.deadline());
    line.put(numbered(1) + Bytes{1, 2, 3});
    EXPECT_FALSE(line.parser.deadline());
    line.pass(1h);
    EXPECT_FALSE(line.parser.expire(line.now));
}

TEST(FrameParser, delivers_a_good_frame_behind_a_false_header_once_the_line_is_quiet) {
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

TEST(FrameParser, is_quiet_only_when_nothing_at_all_arrives) {
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

TEST(FrameParser, has_its_own_quiet_time) {
    Line line{{.quiet = 100ms}};
    line.put(header(1000) + numbered(1));
    EXPECT_EQ(line.parser.deadline(), line.now + 100ms);
    line.pass(99ms);
    EXPECT_FALSE(line.parser.expire(line.now));
    line.pass(1ms);
    EXPECT_TRUE(line.parser.expire(line.now));
}

TEST(FrameParser, lets_a_good_frame_arrive_in_slow_pieces) {
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

TEST(FrameParser, gives_up_what_is_overdue_after_a_second_where_the_line_rate_is_unknown) {
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

TEST(FrameParser, gives_up_what_is_overdue_by_the_line_rate_where_it_is_known) {
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

TEST(FrameParser, does_not_wait_for_ever_for_a_header) {
    Line line{{.line_rate = 1000}};
    line.put(Bytes{ano::head});
    EXPECT_EQ(line.parser.deadline(), line.now + 50ms);
    line.pass(208ms);
    line.expire();
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_FALSE(line.parser.deadline());
}

TEST(FrameParser, gives_up_thousands_of_overdue_candidates_in_one_step) {
    Line line{{.max_data = 65535}};
    line.put(Bytes(43000, ano::head));
    line.pass(50ms);
    EXPECT_FALSE(line.parser.expire(line.now));
    line.pass(950ms);
    EXPECT_TRUE(line.parser.expire(line.now));
    EXPECT_FALSE(line.parser.next());
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_EQ(line.counters().expired, 43000u);
}

TEST(FrameParser, gives_an_overdue_candidate_no_company_that_is_still_arriving) {
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

TEST(FrameParser, finds_the_end_of_a_candidate_that_was_searched_behind) {
    Line line;
    const Bytes frame = support::frame(1, 2, 3, header(500) + Bytes(200, 0x21) + header(600) + Bytes(400, 7));
    line.put(begin_of(frame, 500));
    line.pass(60ms);
    line.expire();
    line.put(rest_of(frame, 500) + numbered(1));
    EXPECT_EQ(line.frames, (Frames{frame, numbered(1)}));
}

TEST(FrameParser, waits_for_nothing_at_the_end_of_input) {
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

TEST(FrameParser, joins_nothing_across_the_end_of_input) {
    Line line;
    line.put(begin_of(numbered(1), 10));
    line.finish();
    line.put(rest_of(numbered(1), 10) + numbered(2));
    EXPECT_EQ(line.frames, Frames{numbered(2)});
}

// --- False headers, recognised by what was heard

constexpr std::uint8_t stranger = 0x77;

// Two frames of 0xDC have been heard, with id 0x01 and 13 bytes of DATA.
struct HeardLine : Line {
    explicit HeardLine(FrameParser::Options options = {}) : Line{options} {
        put(numbered(100) + numbered(101));
        frames.clear();
    }
};

const Bytes pair_of_frames = numbered(1) + numbered(2);

TEST(FrameParser, lets_two_good_frames_in_a_row_pass_a_header_from_a_stranger) {
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

TEST(FrameParser, lets_them_pass_when_other_bytes_stand_before_them) {
    for (const std::size_t at_once : {1u, 5u, 1000u}) {
        HeardLine line;
        line.put(header(4000, stranger) + Bytes(100) + numbered(3) + Bytes(7, ano::head) + numbered(4) + Bytes(1), at_once);
        EXPECT_TRUE(line.frames.empty());
        line.put(header(900) + pair_of_frames, at_once);
        EXPECT_EQ(line.frames, (Frames{numbered(3), numbered(4), numbered(1), numbered(2)}));
    }
}

TEST(FrameParser, lets_them_pass_whatever_number_of_headers_stands_before_them) {
    for (const std::size_t at_once : {1u, 1000u}) {
        HeardLine line;
        for (std::size_t i = 0; i < 100; ++i) line.put(header(2000 + 7 * i, i % 2 ? stranger : 0xDC), at_once);
        line.put(pair_of_frames, at_once);
        EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
        EXPECT_EQ(line.counters().expired, 100u);
    }
}

TEST(FrameParser, lets_them_pass_when_false_headers_in_their_DATA_end_where_they_end) {
    const auto holding = [](const Bytes& inner) { return support::frame(0xDC, 0xFE, 0x01, inner); };
    const Bytes first = holding(header(7) + header(1) + Bytes(1));
    const Bytes second = holding(Bytes{9} + header(5) + Bytes(5));
    HeardLine line;
    line.put(header(1000, stranger) + first + second);
    EXPECT_EQ(line.frames, (Frames{first, second}));
}

TEST(FrameParser, lets_no_single_frame_pass_a_header_nor_two_that_are_apart) {
    HeardLine line;
    line.put(header(1000, stranger) + numbered(1) + Bytes(1) + numbered(2) + Bytes(1));
    EXPECT_TRUE(line.frames.empty());
    line.pass(50ms);
    line.expire();
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
}

TEST(FrameParser, lets_no_frames_pass_that_are_damaged_or_from_strangers) {
    Bytes damaged = numbered(2);
    damaged[10] ^= 1;
    Bytes of_wrong_add = numbered(2);    // its other check holds, so that it is looked at
    of_wrong_add.back() ^= 1;
    const Bytes strange = support::frame(stranger, 0xFE, 0x01, Bytes(13));
    for (const Bytes& second : {damaged, of_wrong_add, strange}) {
        HeardLine line;
        line.put(header(1000, stranger) + numbered(1) + second + Bytes(1) + second + numbered(1) + Bytes(1));
        EXPECT_TRUE(line.frames.empty());
    }
}

// Its source was heard, but a bit of LEN was flipped on the way.
TEST(FrameParser, lets_frames_pass_a_header_whose_LEN_is_more_than_was_heard) {
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

TEST(FrameParser, waits_for_a_LEN_that_was_heard) {
    const Bytes longer = support::frame(0xDC, 0xFE, 0x01, Bytes(60));
    HeardLine line;
    line.put(header(60) + pair_of_frames);
    EXPECT_EQ(line.frames.size(), 2u);
    line.put(longer);
    line.frames.clear();
    line.put(header(60) + pair_of_frames);
    EXPECT_TRUE(line.frames.empty());
    line.put(header(61) + pair_of_frames);    // which ends the wait
    EXPECT_EQ(line.frames.size(), 4u);
}

TEST(FrameParser, waits_as_long_as_ever_where_nothing_was_heard) {
    Line line;
    line.put(header(1000) + numbered(1) + numbered(2) + numbered(3));
    EXPECT_TRUE(line.frames.empty());
    EXPECT_EQ(line.parser.deadline(), line.now + 50ms);
}

// Behind a header that gives way there may be a frame that is on its way: that one waits for its rest.
TEST(FrameParser, gives_way_one_candidate_at_a_time) {
    const Bytes log = support::frame(0xDC, 0xFE, 0xA0, Bytes(10) + pair_of_frames + Bytes(300));
    for (std::size_t cut = ano::overhead; cut < log.size(); ++cut) {
        HeardLine line;
        line.put(header(4000, stranger) + begin_of(log, cut));
        EXPECT_TRUE(line.frames.empty());
        line.put(rest_of(log, cut) + pair_of_frames);
        EXPECT_EQ(line.frames, (Frames{log, numbered(1), numbered(2)})) << "cut at " << cut;
    }
}

TEST(FrameParser, keeps_what_it_heard_over_the_end_of_input) {
    HeardLine line;
    line.finish();
    line.put_datagram(begin_of(numbered(3), 7));
    line.put_datagram(header(1000, stranger) + pair_of_frames);
    line.finish();
    line.put(header(1000, stranger) + pair_of_frames);
    EXPECT_EQ(line.frames.size(), 4u);
}

// The limit for the search: a look at a header, and each header that gives way, costs the credit of 32 bytes of good frames. The
// credit is at most 65536 bytes, and begins full.
struct FloodedLine : HeardLine {
    FloodedLine() {
        const Bytes flood = header(4000, stranger) + Bytes(3994, ano::head) + Bytes(8, 0xFF);
        put(flood, 100);
        EXPECT_EQ(parser.waiting(), 0u);
    }
};

TEST(FrameParser, looks_for_no_two_frames_in_a_row_behind_more_headers_than_good_frames_paid_for) {
    FloodedLine line;
    line.put(header(1000, stranger) + pair_of_frames + pair_of_frames);
    EXPECT_TRUE(line.frames.empty());
    line.pass(50ms);
    line.expire();
    EXPECT_EQ(line.frames.size(), 4u);
}

TEST(FrameParser, looks_for_them_again_when_good_frames_have_paid_for_it) {
    for (const unsigned good : {4u, 5u}) {    // of 21 bytes, for two looks and a header that gives way
        FloodedLine line;
        for (unsigned i = 0; i < good; ++i) line.put(numbered(i));
        line.put(header(1000, stranger) + pair_of_frames);
        EXPECT_EQ(line.frames.size(), good == 4 ? good : good + 2);
    }
}

TEST(FrameParser, has_every_header_that_gives_way_paid_for) {
    for (const unsigned good : {7u, 8u}) {    // for three looks and two headers that give way
        FloodedLine line;
        for (unsigned i = 0; i < good; ++i) line.put(numbered(i));
        line.put(header(1000, stranger) + header(1000, stranger) + pair_of_frames);
        EXPECT_EQ(line.frames.size(), good == 7 ? good : good + 2);
    }
}

TEST(FrameParser, finds_two_in_a_row_among_what_it_could_not_look_at_when_it_came) {
    FloodedLine line;
    for (unsigned i = 0; i < 2; ++i) line.put(numbered(i));    // they pay for one look
    Bytes good;
    for (unsigned i = 2; i < 7; ++i) good = good + numbered(i);
    const Bytes behind = good + header(1000, stranger) + pair_of_frames;
    line.put(header(behind.size() - 1, stranger) + behind);
    EXPECT_EQ(line.frames.size(), 2u);
    line.put(Bytes(1));    // the first header's frame is whole, and bad
    EXPECT_EQ(line.frames.size(), 9u);
    EXPECT_EQ(line.counters().expired, 1u);
}

TEST(FrameParser, saves_what_good_frames_pay_up_to_a_limit) {
    HeardLine line;
    for (unsigned i = 0; i < 4000; ++i) line.put(numbered(i));
    line.frames.clear();
    line.put(header(4096, stranger) + Bytes(2046, ano::head) + Bytes(8, 0xFF), 100);    // two looks are left
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

// The first frame of a known sender with an id of any length, and tunnel frames of anybody.
TEST_P(KnownSender, has_no_frames_taken_out_of_its_DATA) {
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
        // As a line of 1200 baud brings them, byte by byte.
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

// The limit of the rule: a long frame of a sender that was never heard can't be told from a false header.
TEST(FrameParser, takes_the_frames_out_of_a_strangers_first_frame_when_it_comes_in_pieces) {
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

// --- Datagrams

TEST(FrameParser, continues_what_a_datagram_left_over) {
    Line line;
    line.put_datagram(numbered(1) + begin_of(numbered(2), 7));
    line.pass(99ms);
    line.put_datagram(rest_of(numbered(2), 7) + numbered(3));
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2), numbered(3)}));
    EXPECT_EQ(line.counters().skipped_bytes, 0u);
}

TEST(FrameParser, abandons_what_a_datagram_left_over_100_ms_ago) {
    Line line;
    line.put_datagram(begin_of(numbered(2), 7));
    line.pass(100ms);
    line.put_datagram(rest_of(numbered(2), 7) + numbered(3));
    EXPECT_EQ(line.frames, Frames{numbered(3)});
    EXPECT_EQ(line.counters().expired, 1u);
}

TEST(FrameParser, abandons_what_is_left_over_when_a_datagram_starts_with_a_whole_good_frame) {
    Line line;
    line.put_datagram(begin_of(numbered(1), 7));
    line.put_datagram(numbered(2) + begin_of(numbered(3), 7));
    EXPECT_EQ(line.frames, Frames{numbered(2)});
    EXPECT_EQ(line.counters().skipped_bytes, 7u);
    line.put_datagram(rest_of(numbered(3), 7));
    EXPECT_EQ(line.frames, (Frames{numbered(2), numbered(3)}));
}

TEST(FrameParser, keeps_what_is_left_over_when_a_datagram_starts_with_a_frame_larger_than_max_data) {
    // The rest of the outer frame is the beginning of an inner one that is good, but too large.
    Line line{{.max_data = 40}};
    const Bytes outer = support::frame(1, 2, 3, Bytes(10) + header(41) + Bytes(24));
    Bytes datagram = rest_of(outer, 16);
    datagram.resize(ano::overhead + 41);
    ano::seal(datagram);
    ASSERT_TRUE(ano::frame_at(datagram));
    line.put_datagram(begin_of(outer, 16));
    line.put_datagram(datagram);
    EXPECT_EQ(line.frames, Frames{outer});
}

TEST(FrameParser, exposes_the_frames_inside_an_abandoned_left_over) {
    const Tunnel tunnel;
    for (const ano::Duration pause : {ano::Duration{1ms}, ano::Duration{100ms}}) {
        Line line;
        line.put_datagram(begin_of(tunnel.whole, tunnel.cut));
        EXPECT_TRUE(line.frames.empty());
        line.pass(pause);
        line.put_datagram(numbered(3));
        EXPECT_EQ(line.frames, (Frames{tunnel.first, tunnel.second, numbered(3)}));
    }
}

TEST(FrameParser, joins_no_candidate_inside_an_abandoned_left_over_with_the_next_datagram) {
    Line line;
    line.put_datagram(header(200) + begin_of(numbered(1), 10));
    line.pass(100ms);
    line.put_datagram(rest_of(numbered(1), 10) + numbered(2));
    EXPECT_EQ(line.frames, Frames{numbered(2)});
    EXPECT_EQ(line.counters().expired, 2u);
}

TEST(FrameParser, takes_a_datagram_larger_than_its_room_in_pieces) {
    Line line{{.max_data = 20}};
    Frames sent;
    Bytes datagram;
    for (unsigned i = 0; datagram.size() < 60000; ++i) datagram = datagram + sent.emplace_back(numbered(i));
    line.put_datagram(begin_of(numbered(9999), 15));
    ASSERT_LT(line.parser.prepare().size(), datagram.size());
    line.put_datagram(datagram);
    EXPECT_EQ(line.frames, sent);
    EXPECT_EQ(line.counters().skipped_bytes, 15u);
}

TEST(FrameParser, takes_a_datagram_of_60_frames) {
    Frames sent;
    Bytes datagram;
    for (unsigned i = 0; i < 60; ++i) datagram = datagram + sent.emplace_back(numbered(i));
    Line line;
    for (int i = 0; i < 5; ++i) {
        line.frames.clear();
        line.put_datagram(datagram);
        EXPECT_EQ(line.frames, sent);
    }
}

TEST(FrameParser, takes_an_empty_datagram_for_nothing) {
    Line line;
    line.put_datagram({});
    line.put_datagram(begin_of(numbered(1), 7));
    line.put_datagram({});
    line.put_datagram(rest_of(numbered(1), 7));
    EXPECT_EQ(line.frames, Frames{numbered(1)});
}

// --- The previous protocol version

Bytes v7_frame(std::uint8_t id, const Bytes& data) {
    Bytes bytes = Bytes{0xAA, 0xFF, id, static_cast<std::uint8_t>(data.size())} + data;
    const ano::Checks checks = ano::checks_of(bytes);
    return bytes + Bytes{checks.sum, checks.add};
}

TEST(FrameParser, sees_frames_of_the_previous_version_however_they_are_cut) {
    const Bytes one = v7_frame(0x03, {1, 2, 3, 4, 5, 6, 0xAB});
    for (std::size_t at_once = 1; at_once < 2 * one.size(); ++at_once) {
        Line line;
        for (int i = 0; i < 10; ++i) line.put(one, at_once);
        line.finish();
        EXPECT_EQ(line.counters().v7_frames, 10u) << "by " << at_once;
        EXPECT_TRUE(line.frames.empty());
    }
}

TEST(FrameParser, sees_no_frame_of_the_previous_version_where_a_check_is_wrong) {
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

TEST(FrameParser, sees_no_frame_of_the_previous_version_in_the_data_of_a_good_one) {
    Line line;
    for (int i = 0; i < 10; ++i) line.put(support::frame(1, 2, 3, v7_frame(0x03, {1, 2, 3})));
    EXPECT_EQ(line.counters().v7_frames, 0u);
}

TEST(FrameParser, sees_no_frame_of_the_previous_version_around_a_good_one) {
    const Bytes one = v7_frame(0x03, {1, 2, 3, 4, 5, 6});
    for (std::size_t cut = 1; cut < one.size(); ++cut) {
        Line line;
        line.put(begin_of(one, cut) + numbered(1) + rest_of(one, cut));
        EXPECT_EQ(line.frames, Frames{numbered(1)});
        EXPECT_EQ(line.counters().v7_frames, 0u) << cut;
    }
}

// Crafted input must not cost more for being looked at twice.
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

// --- Padding

TEST(FrameParser, zeros_are_padding_only_right_behind_a_frame) {
    Line line{{.zero_padding = true}};
    line.put(numbered(1) + Bytes(5));
    EXPECT_EQ(line.counters().skipped_bytes, 0u);
    line.put(Bytes{1});
    line.put(Bytes(3));
    line.put(numbered(2));
    EXPECT_EQ(line.frames.size(), 2u);
    EXPECT_EQ(line.counters().skipped_bytes, 4u);
    EXPECT_EQ(line.counters().bytes_in, 2 * numbered(1).size() + 4);
}

// --- Resources

TEST(FrameParser, allocates_nothing_after_construction) {
    FrameParser parser{{.max_data = 600}};
    const Bytes input = header(255) + numbered(1) + Bytes(30, ano::head) + Bytes{8, 0} + v7_frame(1, Bytes(30)) +
                        support::frame(1, 2, 3, Bytes(600)) + header(601) + header(600);
    const auto before = support::allocations;
    TimePoint now{};
    std::uint64_t frames = 0;
    for (int i = 0; i < 200; ++i) {
        parser.begin_datagram(input, now);
        for (std::span<const std::uint8_t> rest{input}; !rest.empty();) {
            const auto room = parser.prepare();
            const std::size_t n = std::min<std::size_t>({room.size(), rest.size(), 100});
            std::copy_n(rest.data(), n, room.data());
            parser.commit(n, now);
            rest = rest.subspan(n);
            while (parser.next()) ++frames;
        }
        now += 60ms;
        while (parser.expire(now))
            while (parser.next()) ++frames;
    }
    parser.finish();
    while (parser.next()) ++frames;
    EXPECT_EQ(support::allocations, before);
    EXPECT_EQ(frames, 400u);
}

}    // namespace
