#include "parser_line.hpp"

#include <support/allocations.hpp>

using namespace parsing;

namespace parser_tests {
namespace {

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

TEST(FrameParser, finds_frames_however_they_are_split) {
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

TEST(FrameParser, accepts_only_frames_without_data_if_max_data_is_0) {
    Line line{{.max_data = 0}};
    line.put(support::frame(1, 2, 3) + support::frame(1, 2, 3, {0}) + support::frame(4, 5, 6));
    EXPECT_EQ(line.frames, (Frames{support::frame(1, 2, 3), support::frame(4, 5, 6)}));
    EXPECT_EQ(line.counters().bad_length, 1u);
}

TEST(FrameParser, accepts_the_largest_frames_in_succession) {
    Line line{{.max_data = 65535}};
    const Bytes largest = support::frame(1, 2, 0xB0, Bytes(65535, 0x5A));
    for (int i = 0; i < 5; ++i) {
        line.put(Bytes(static_cast<std::size_t>(i)));    // so that they begin at different positions of the buffer
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

TEST(FrameParser, limits_max_data_to_the_largest_LEN) {
    Line line{{.max_data = SIZE_MAX}};
    const Bytes largest = support::frame(1, 2, 0xB0, Bytes(65535, 0x5A));
    line.put(largest);
    EXPECT_EQ(line.frames, Frames{largest});
}

TEST(FrameParser, returns_views_that_stay_valid_until_the_next_prepare) {
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
    // The valid frame begins at the second byte of the invalid one, whose check would be inside it.
    Line line{{.max_data = 20}};
    line.put(Bytes{ano::head} + numbered(1));
    line.put(Bytes{ano::head, ano::head, ano::head} + numbered(2));
    line.finish();
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)}));
    EXPECT_EQ(line.counters().skipped_bytes, 4u);
}

TEST(FrameParser, finds_a_valid_frame_inside_an_invalid_one) {
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

TEST(FrameParser, finds_a_valid_frame_after_many_overlapping_candidates) {
    // All of them extend beyond the valid frame; the last one extends into the bytes after it.
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

TEST(FrameParser, accepts_the_largest_frame_after_a_rejected_one) {
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

TEST(FrameParser, finds_a_frame_among_heads_however_near_its_end_it_is_split) {
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

// Candidates whose LEN is two HEADs are rejected 64 at a time, as far as sums are available: the valid one may be any of these.
TEST(FrameParser, finds_a_frame_among_heads_wherever_it_begins) {
    const Bytes frame = support::frame(ano::head, ano::head, ano::head, Bytes(0xABAB, 0x11));
    for (std::size_t heads = 990; heads < 1060; ++heads) {
        Line line{{.max_data = 65535}};
        line.put(Bytes(heads, ano::head) + frame + Bytes(3000, 0x33));
        line.finish();
        EXPECT_EQ(line.frames, Frames{frame}) << heads;
    }
}

TEST(FrameParser, loses_none_of_8_valid_frames_after_a_false_header_80_times) {
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

TEST(FrameParser, loses_none_of_80_valid_frames_in_10_groups_with_a_pause_after_each) {
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

// --- Padding

TEST(FrameParser, treats_zeros_as_padding_only_directly_after_a_frame) {
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
}    // namespace parser_tests
