#include <ano/v7.hpp>
#include <support/allocations.hpp>
#include <support/both_v7_parsers.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

namespace v7_tests {

using namespace ano;
using namespace std::chrono_literals;
using support::BothV7Parsers;
using support::Bytes;
using support::v7_frame;
using support::operator+;

namespace {

const support::V7Vectors& vectors() {
    static const support::V7Vectors all = support::v7_vectors();
    return all;
}

TEST(V7Frame, of_every_valid_vector_is_found_and_made_again) {
    ASSERT_EQ(vectors().valid.size(), 36u);
    for (const auto& row : vectors().valid) {
        const auto frame = v7::frame_at(row.frame);
        ASSERT_TRUE(frame) << row.meaning;
        EXPECT_EQ(frame->bytes().size(), row.frame.size());
        EXPECT_EQ(v7_frame(frame->destination(), frame->id(), {frame->data().begin(), frame->data().end()}), row.frame);
    }
    const auto unlock = v7::frame_at(vectors().frame(1));
    EXPECT_EQ(unlock->destination(), v7::address::broadcast);
    EXPECT_EQ(unlock->id(), 0xE0);
    EXPECT_EQ(unlock->data().size(), 11u);
    EXPECT_EQ(unlock->checks(), (Checks{0xA5, 0x85}));
}

TEST(V7Frame, is_refused_when_it_is_cut_or_damaged) {
    const Bytes& whole = vectors().frame(22);
    for (std::size_t n = 0; n < whole.size(); ++n) EXPECT_FALSE(v7::frame_at(std::span{whole}.first(n)));
    for (std::size_t i = 0; i < whole.size(); ++i) {
        Bytes bad = whole;
        bad[i] ^= 1;
        EXPECT_FALSE(v7::frame_at(bad)) << i;
    }
}

TEST(V7Frame, of_the_largest_and_the_smallest_size) {
    EXPECT_EQ(v7_frame(0xFF, 0xF1, Bytes(255, 0xAA)).size(), v7::max_frame_size);
    EXPECT_EQ(v7_frame(0xAF, 0xFB).size(), v7::overhead);
    Bytes out(300);
    EXPECT_EQ(v7::encode(out, 0xFF, 0xF1, Bytes(256)), 0u) << "LEN is one byte";
    EXPECT_EQ(v7::encode(std::span{out}.first(8), 0xFF, 0xF1, Bytes(3)), 0u) << "no room";
}

TEST(V7Parser, finds_every_valid_vector_however_they_are_cut) {
    Bytes line;
    std::vector<Bytes> sent;
    for (const auto& row : vectors().valid) {
        sent.push_back(row.frame);
        line = line + row.frame;
    }
    for (std::size_t at_once = 1; at_once < 60; ++at_once) {
        BothV7Parsers both;
        both.put(line, at_once);
        EXPECT_EQ(both.frames, sent);
        both.finish();
        EXPECT_EQ(both.difference(), "");
    }
}

// Section 9: `bad` lines.
TEST(V7Parser, a_damaged_frame_costs_none_of_the_thirty_behind_it) {
    ASSERT_EQ(vectors().bad.size(), 11u);
    const Bytes good = support::hex("AAAF0D045E06FA00C8F9");
    for (const auto& row : vectors().bad) {
        for (const std::size_t at_once : {std::size_t{1}, std::size_t{7}, std::size_t{4096}}) {
            BothV7Parsers both;
            both.put(row.bytes, at_once);
            for (int i = 0; i < 30; ++i) both.put(good, at_once);
            // Doubled AA: the frame behind the first AA is good.
            const std::size_t inside = row.meaning.starts_with("doubled AA") ? 1 : 0;
            EXPECT_EQ(both.frames, std::vector<Bytes>(30 + inside, good)) << row.meaning;
            both.finish();
            EXPECT_EQ(both.difference(), "") << row.meaning;
        }
    }
}

TEST(V7Parser, a_frame_behind_one_that_was_cut_off_comes_after_the_quiet_time) {
    BothV7Parsers both;
    const Bytes good = vectors().frame(22);
    both.put(support::hex("AAAFF1FF0102030405"));    // claims 255 bytes
    both.put(good);
    EXPECT_TRUE(both.frames.empty());
    ASSERT_EQ(both.parser.deadline(), both.now + 20ms);
    both.now += 19ms;
    both.expire();
    EXPECT_TRUE(both.frames.empty());
    both.now += 1ms;
    both.expire();
    EXPECT_EQ(both.frames, std::vector<Bytes>{good});
    EXPECT_FALSE(both.parser.deadline());
    EXPECT_EQ(both.parser.counters().expired, 1u);
}

TEST(V7Parser, a_frame_that_pauses_is_not_given_up_while_no_good_one_is_behind_it) {
    BothV7Parsers both;
    const Bytes good = vectors().frame(22);
    both.put(std::span{good}.first(9));
    both.now += 10s;
    both.expire();
    both.put(std::span{good}.subspan(9));
    EXPECT_EQ(both.frames, std::vector<Bytes>{good});
}

TEST(V7Parser, keeps_the_rest_of_a_datagram_for_100_ms) {
    const Bytes good = vectors().frame(22);
    for (const auto pause : {99ms, 100ms}) {
        BothV7Parsers both;
        both.put(std::span{good}.first(9));
        both.now += pause;
        const auto rest = std::span{good}.subspan(9);
        both.parser.begin_datagram(rest, both.now);
        while (both.parser.next()) {}
        both.put(rest);
        EXPECT_EQ(both.frames.size(), pause < 100ms ? 1u : 0u);
    }
    BothV7Parsers both;
    both.put(std::span{good}.first(9));
    both.parser.begin_datagram(good, both.now);
    both.put(good);
    EXPECT_EQ(both.frames, std::vector<Bytes>{good}) << "at once: the datagram begins with a frame";
}

TEST(V7Parser, does_not_allocate) {
    v7::Parser parser;
    const Bytes bytes = vectors().bad[0].bytes + vectors().frame(22);
    const std::size_t before = support::allocations;
    for (int i = 0; i < 1000; ++i) {
        std::copy(bytes.begin(), bytes.end(), parser.prepare().begin());
        parser.commit(bytes.size(), {});
        while (parser.next()) {}
    }
    EXPECT_EQ(support::allocations, before);
    EXPECT_EQ(parser.counters().frames_in, 1000u);
}

// Section 4: the DATA of a row are as long as the note says.
TEST(V7Table, has_the_lengths_of_the_note) {
    const auto size_of = [](std::uint8_t id) {
        return v7::layouts_of(id).empty() ? 0u : unsigned{v7::layouts_of(id)[0].fixed_size};
    };
    EXPECT_EQ(size_of(0x01), 13u);
    EXPECT_EQ(size_of(0x02), 14u);
    EXPECT_EQ(size_of(0x05), 9u);
    EXPECT_EQ(size_of(0x08), 8u);
    EXPECT_EQ(size_of(0x32), 12u);
    EXPECT_EQ(size_of(0x34), 7u);
    EXPECT_EQ(size_of(0xE1), 2u);
    EXPECT_EQ(size_of(0xE2), 6u);
    EXPECT_EQ(size_of(0x03), 7u) << "as in V8";
    EXPECT_EQ(size_of(0x61), 22u) << "as in V8";
    for (const int id : {0x31, 0x35, 0xB0, 0xC0, 0xC1, 0xE3, 0xF0}) EXPECT_EQ(size_of(static_cast<std::uint8_t>(id)), 0u);
}

static_assert(v7::find_difference(0x02) != nullptr && v7::find_difference(0x03) == nullptr);

}    // namespace
}    // namespace v7_tests
