// Frames, parser and message table of V7.
#include <ano/v7.hpp>
#include <support/allocations.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace v7_tests {

using namespace std::chrono_literals;
using support::Bytes;
using support::operator+;
using support::v7_frame;
using support::v7_vectors;
namespace v7 = ano::v7;

namespace {

using Frames = std::vector<Bytes>;

class V7Line {
public:
    explicit V7Line(v7::FrameParser::Options options = {}) : parser{options} {}

    v7::FrameParser parser;
    ano::TimePoint now{};
    Frames frames;

    void put(std::span<const std::uint8_t> bytes, std::size_t at_once = SIZE_MAX) {
        while (!bytes.empty()) {
            const auto room = parser.prepare();
            ASSERT_GE(room.size(), 4096u);
            const std::size_t n = std::min({room.size(), bytes.size(), at_once});
            std::copy_n(bytes.data(), n, room.data());
            parser.commit(n, now);
            bytes = bytes.subspan(n);
            take();
        }
    }
    void feed_datagram(const Bytes& bytes) {
        parser.begin_datagram(bytes, now);
        take();
        put(bytes);
    }
    void expire() {
        while (parser.expire(now)) take();
    }
    void finish() {
        parser.finish();
        take();
    }

private:
    void take() {
        while (const auto frame = parser.next()) frames.emplace_back(frame->bytes().begin(), frame->bytes().end());
    }
};

const Bytes good = support::hex("AAAF0D045E06FA00C8F9");

// --- Frames

TEST(V7Frame, valid_vectors_are_frames_and_are_encoded_again) {
    const auto vectors = v7_vectors("valid");
    ASSERT_GE(vectors.size(), 30u);
    for (const auto& vector : vectors) {
        const auto frame = v7::frame_at(vector.v7);
        ASSERT_TRUE(frame) << vector.meaning;
        EXPECT_EQ(frame->bytes().size(), vector.v7.size()) << vector.meaning;
        EXPECT_EQ(v7_frame(frame->destination(), frame->id(), {frame->data().begin(), frame->data().end()}), vector.v7)
            << vector.meaning;
    }
}

TEST(V7Frame, sides_of_a_pair_are_frames_of_their_version) {
    const auto vectors = v7_vectors("pair");
    ASSERT_GE(vectors.size(), 12u);
    for (const auto& vector : vectors) {
        EXPECT_TRUE(v7::frame_at(vector.v7)) << vector.meaning;
        EXPECT_TRUE(ano::frame_at(vector.v8)) << vector.meaning;
    }
}

TEST(V7Frame, is_refused_if_incomplete_too_long_or_damaged) {
    for (std::size_t n = 0; n < good.size(); ++n) EXPECT_FALSE(v7::frame_at(std::span{good}.first(n))) << n;
    EXPECT_TRUE(v7::frame_at(good, 4));
    EXPECT_FALSE(v7::frame_at(good, 3));
    for (std::size_t at = 0; at < good.size(); ++at)
        for (unsigned bit = 0; bit < 8; ++bit) {
            Bytes bad = good;
            bad[at] ^= static_cast<std::uint8_t>(1u << bit);
            EXPECT_FALSE(v7::frame_at(bad)) << at << ' ' << bit;
        }
}

TEST(V7Frame, encode_refuses_what_does_not_fit) {
    std::array<std::uint8_t, 300> out{};
    const Bytes largest(255, 7);
    EXPECT_EQ(v7::encode(out, 0xFF, 0xF1, largest), v7::max_frame_size);
    EXPECT_EQ(v7::encode(out, 0xFF, 0xF1, Bytes(256)), 0u);
    EXPECT_EQ(v7::encode(std::span{out}.first(260), 0xFF, 0xF1, largest), 0u);
    EXPECT_EQ(v7::encode(std::span{out}.first(6), 0xFF, 0xFB, {}), 6u);
}

// --- The parser

TEST(V7Parser, finds_the_valid_vectors_however_they_are_cut) {
    Bytes all;
    Frames sent;
    for (const auto& vector : v7_vectors("valid")) {
        all = all + vector.v7;
        sent.push_back(vector.v7);
    }
    for (const std::size_t at_once : {1u, 2u, 3u, 7u, 64u, 5000u}) {
        V7Line line;
        line.put(all, at_once);
        EXPECT_EQ(line.frames, sent) << "by " << at_once;
        EXPECT_EQ(line.parser.counters().skipped_bytes, 0u);
        EXPECT_EQ(line.parser.waiting(), 0u);
        EXPECT_EQ(line.parser.counters().frames_in, sent.size());
    }
}

TEST(V7Parser, a_damaged_frame_costs_only_itself) {
    const auto vectors = v7_vectors("bad");
    ASSERT_GE(vectors.size(), 11u);
    for (const auto& vector : vectors) {
        Frames expected;
        Bytes bytes = vector.v7;
        // Behind a doubled HEAD there is the whole frame.
        if (vector.meaning.starts_with("doubled AA")) expected.push_back(good);
        for (int i = 0; i < 30; ++i) {
            bytes = bytes + good;
            expected.push_back(good);
        }
        for (const std::size_t at_once : {1u, 5u, 1000u}) {
            V7Line line;
            line.put(bytes, at_once);
            EXPECT_EQ(line.frames.size(), expected.size()) << vector.meaning << ", by " << at_once;
            EXPECT_EQ(line.frames, expected) << vector.meaning << ", by " << at_once;
        }
    }
}

TEST(V7Parser, finds_a_good_frame_inside_a_damaged_one) {
    Bytes bad = v7_frame(0xFF, 0xF1, good + good + Bytes(9, v7::head));
    bad.back() ^= 1;
    V7Line line;
    line.put(bad + good);
    line.finish();
    EXPECT_EQ(line.frames, Frames(3, good));
    EXPECT_EQ(line.parser.counters().skipped_bytes, bad.size() - 2 * good.size());
}

TEST(V7Parser, refuses_more_than_max_data_from_the_header_alone) {
    V7Line line{{.max_data = 4}};
    line.put(Bytes{0xAA, 0xFF, 0xF1, 5});
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_EQ(line.parser.counters().bad_length, 1u);
    line.put(good);
    EXPECT_EQ(line.frames, Frames{good});
}

TEST(V7Parser, a_truncated_frame_makes_way_for_a_whole_one_after_20_ms_without_a_byte) {
    V7Line line;
    line.put(Bytes{0xAA, 0xAF, 0x0D, 200} + good);
    EXPECT_TRUE(line.frames.empty());
    EXPECT_EQ(line.parser.deadline(), line.now + 20ms);
    line.now += 19ms;
    EXPECT_FALSE(line.parser.expire(line.now));
    line.now += 1ms;
    line.expire();
    EXPECT_EQ(line.frames, Frames{good});
    EXPECT_FALSE(line.parser.deadline());
    EXPECT_EQ(line.parser.counters().expired, 1u);
}

TEST(V7Parser, the_rest_of_a_frame_is_waited_for_200_ms) {
    V7Line line;
    line.put(std::span{good}.first(5));
    line.now += 199ms;
    line.expire();
    line.put(std::span{good}.subspan(5));
    EXPECT_EQ(line.frames, Frames{good});
    line.put(std::span{good}.first(5));
    line.now += 20ms;
    line.expire();
    EXPECT_EQ(line.parser.deadline(), line.now + 180ms);
    line.now += 180ms;
    line.expire();
    EXPECT_EQ(line.parser.waiting(), 0u);
    EXPECT_EQ(line.parser.counters().skipped_bytes, 5u);
}

// A bridge that pauses inside a frame: the rest is waited for, but not while whole frames follow.
TEST(V7Parser, with_frame_gap_a_false_header_delays_no_frame_for_longer_than_quiet) {
    V7Line line{{.frame_gap = 500ms}};
    const Bytes whole = v7_frame(0xFF, 0x03, Bytes(7, 1));
    line.put(Bytes{0xAA, 0xFF, 0x03, 200} + whole + whole);
    line.now += 20ms;
    ASSERT_TRUE(line.parser.deadline());
    EXPECT_LE(*line.parser.deadline(), line.now);
    line.expire();
    EXPECT_EQ(line.frames, (Frames{whole, whole}));
    line.frames.clear();
    const Bytes cut = v7_frame(0xFF, 0x03, Bytes(40, 2));
    line.put(std::span{cut}.first(30));
    line.now += 400ms;
    line.expire();
    EXPECT_TRUE(line.frames.empty());
    line.put(std::span{cut}.subspan(30));
    EXPECT_EQ(line.frames, Frames{cut});
    line.frames.clear();
    // whole frames, but also the beginning of another one
    line.put(Bytes{0xAA, 0xFF, 0x03, 200} + whole + Bytes{0xAA, 0xFF});
    line.now += 400ms;
    line.expire();
    EXPECT_TRUE(line.frames.empty());
    line.now += 100ms;
    line.expire();
    EXPECT_EQ(line.frames, Frames{whole});
}

TEST(V7Parser, a_datagram_that_begins_with_a_frame_ends_the_one_before) {
    V7Line line;
    line.feed_datagram(Bytes{0xAA, 0xAF, 0x0D, 200});
    line.feed_datagram(good);
    EXPECT_EQ(line.frames, Frames{good});
    line.feed_datagram({good.begin(), good.begin() + 5});
    line.now += 99ms;
    line.feed_datagram({good.begin() + 5, good.end()});
    EXPECT_EQ(line.frames, Frames(2, good));
    line.feed_datagram({good.begin(), good.begin() + 5});
    line.now += 100ms;
    line.feed_datagram({good.begin() + 5, good.end()});
    EXPECT_EQ(line.frames, Frames(2, good));
}

TEST(V7Parser, allocates_only_at_construction) {
    V7Line line;
    line.frames.reserve(2000);
    const Bytes bytes = good + Bytes(700, v7::head) + good;
    std::size_t found = 0;
    const auto before = support::allocations;
    for (int i = 0; i < 100; ++i) {
        const auto room = line.parser.prepare();
        std::copy(bytes.begin(), bytes.end(), room.begin());
        line.parser.commit(bytes.size(), line.now);
        while (line.parser.next()) ++found;
        line.parser.expire(line.now += 1s);
        while (line.parser.next()) ++found;
    }
    EXPECT_EQ(support::allocations, before);
    EXPECT_EQ(found, 200u);
}

// --- The table

TEST(V7Table, has_the_lengths_of_the_vendors_text) {
    const struct {
        std::uint8_t id;
        std::size_t size;
    } expected[]{{0x00, 3}, {0x01, 13}, {0x02, 14}, {0x03, 7},  {0x04, 9}, {0x05, 9}, {0x06, 5},  {0x07, 6},
                 {0x08, 8}, {0x09, 4},  {0x0A, 6},  {0x0B, 6},  {0x0C, 4}, {0x0D, 4}, {0x0E, 4},  {0x0F, 4},
                 {0x20, 8}, {0x21, 8},  {0x30, 23}, {0x32, 12}, {0x33, 6}, {0x34, 7}, {0x40, 20}, {0x41, 14},
                 {0x51, 5}, {0x60, 1},  {0x61, 22}, {0xA0, 1},  {0xA1, 4}, {0xE0, 3}, {0xE1, 2},  {0xE2, 6}};
    for (const auto& [id, size] : expected) {
        ASSERT_FALSE(v7::layouts_of(id).empty()) << int{id};
        EXPECT_EQ(v7::layouts_of(id).front().fixed_size, size) << int{id};
    }
    for (const unsigned id : {0x31u, 0x35u, 0xB0u, 0xB1u, 0xB2u, 0xC0u, 0xC1u, 0xC2u, 0xE3u, 0xF0u, 0x11u, 0xC5u})
        EXPECT_TRUE(v7::layouts_of(static_cast<std::uint8_t>(id)).empty()) << id;
}

TEST(V7Table, finds_messages_by_the_name_in_their_version) {
    EXPECT_EQ(v7::find_message("command")->id, 0xE0);
    EXPECT_EQ(v7::find_message("parameter_read")->id, 0xE1);
    EXPECT_EQ(v7::find_message("parameter_value")->id, 0xE2);
    EXPECT_EQ(v7::find_message("euler")->id, 0x03);
    EXPECT_EQ(v7::find_message("flexible3")->id, 0xF3);
    for (const char* name : {"parameter_command", "parameter_info", "image", "firmware", "device_info", "nothing"})
        EXPECT_EQ(v7::find_message(name), nullptr) << name;
}

double number(const char* digits, std::string_view field) {
    const Bytes bytes = support::hex(digits);
    const auto frame = v7::frame_at(bytes);
    if (!frame) return -1e9;
    const ano::Reading reading = v7::read(*frame);
    const ano::Field* f = reading ? reading.field(field) : nullptr;
    return f == nullptr ? -1e9 : reading.number(*f);
}

TEST(V7Table, reads_the_vectors) {
    EXPECT_EQ(number("AAAF010D0D001B004B0501000500FBFF00DFAB", "acc_z"), 1355);
    EXPECT_DOUBLE_EQ(number("AAAF03078F001A00E82A001EEE", "yaw"), 109.84);
    EXPECT_DOUBLE_EQ(number("AAAF020EA6FFBE00C6FE7D6E00003A110000C623", "tmp"), 44.1);
    EXPECT_EQ(number("AAFF320C78000000D3FFFFFF00000080AF8F", "pos_y"), -45);
    EXPECT_EQ(number("AAFF3407000E014B0000003ED5", "angle"), 270);
    EXPECT_EQ(number("AAFF3407000E014B0000003ED5", "dist"), 75);
    EXPECT_TRUE(std::isnan(number("AAFF3407000000FFFFFFFFE046", "dist")));
    EXPECT_EQ(number("AAAFA107FBFFFFFF6572724258", "val"), -5);
    EXPECT_EQ(number("AAAFE2060B00E803000037F0", "val"), 1000);
    EXPECT_EQ(number("AAFF510701010C00F9FFC8CF4F", "dy_1"), -7);
    EXPECT_EQ(number("AAFFE00B10000596000000000000003F59", "cid"), 0x10);
}

}    // namespace
}    // namespace v7_tests
