#include <ano/heard.hpp>
#include <support/bytes.hpp>

#include <gtest/gtest.h>

using ano::Heard;
using support::Bytes;

namespace heard_tests {
namespace {

void note(Heard& heard, const Bytes& bytes) { heard.note(ano::FrameView{bytes}); }

bool credible(const Heard& heard, std::uint8_t source, std::uint8_t id, std::size_t length, std::uint8_t first = 0) {
    const std::uint8_t begin[]{
        ano::head, source, 0xFF, id, static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(length >> 8), first};
    return heard.makes_credible(begin);
}

TEST(Heard, knows_which_ids_are_of_free_length) {
    const auto listed_as_free = [](unsigned id) {
        return id == 0xA0 || id == 0xA1 || (id >= 0xB0 && id <= 0xB2) || (id >= 0xF0 && id <= 0xFB) || id == 0xC0 || id == 0xC2 ||
               (id >= 0xE1 && id <= 0xE3);
    };
    const auto listed_as_fixed = [](unsigned id) {
        return id <= 0x0F || id == 0x20 || id == 0x21 || (id >= 0x30 && id <= 0x35) || id == 0x40 || id == 0x41 || id == 0x51 ||
               id == 0x60 || id == 0x61 || id == 0xC1 || id == 0xE0;
    };
    for (unsigned id = 0; id < 256; ++id) {
        EXPECT_FALSE(listed_as_free(id) && listed_as_fixed(id));
        EXPECT_EQ(ano::is_of_free_length(static_cast<std::uint8_t>(id), 0), !listed_as_fixed(id)) << "id " << id;
    }
}

TEST(Heard, knows_that_a_scan_is_of_free_length_and_a_distance_is_not) {
    for (unsigned type = 0; type < 256; ++type)
        EXPECT_EQ(ano::is_of_free_length(0x34, static_cast<std::uint8_t>(type)), type == 100) << "type " << type;
}

TEST(Heard, trusts_only_tunnel_frames_at_first) {
    const Heard heard;
    for (unsigned id = 0; id < 256; ++id)
        EXPECT_EQ(credible(heard, 0xDC, static_cast<std::uint8_t>(id), 20), id == 0xB1 || id == 0xB2) << "id " << id;
    EXPECT_FALSE(heard.source(0xDC));
}

TEST(Heard, trusts_a_seen_source_with_ids_of_variable_length_and_with_seen_lengths) {
    Heard heard;
    note(heard, support::frame(0xDC, 0xFE, 0x01, Bytes(13)));
    note(heard, support::frame(0xDE, 0xFE, 0x01, Bytes(7)));
    EXPECT_TRUE(heard.source(0xDC));
    EXPECT_FALSE(heard.source(0xFE));
    EXPECT_TRUE(credible(heard, 0xDC, 0xA0, 65535));
    EXPECT_TRUE(credible(heard, 0xDC, 0x34, 401, 100));
    EXPECT_FALSE(credible(heard, 0xDC, 0x34, 401, 99));
    EXPECT_TRUE(credible(heard, 0xDC, 0x01, 13));
    EXPECT_TRUE(credible(heard, 0xDE, 0x01, 13));    // an id has one length, from any sender
    EXPECT_FALSE(credible(heard, 0xDC, 0x01, 14));
    EXPECT_FALSE(credible(heard, 0xDC, 0x02, 14));
    EXPECT_FALSE(credible(heard, 0x77, 0x01, 13));
    EXPECT_FALSE(credible(heard, 0x77, 0xA0, 13));
}

TEST(Heard, remembers_the_largest_LEN) {
    Heard heard;
    for (const std::size_t length : {3u, 65535u, 8u}) note(heard, support::frame(1, 2, 0x03, Bytes(length)));
    EXPECT_TRUE(credible(heard, 1, 0x03, 65535));
}

}    // namespace
}    // namespace heard_tests
