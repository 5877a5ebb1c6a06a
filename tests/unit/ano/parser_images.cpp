// Images are longer than all other frames: they pass by default, and a false header that claims one delays no other frame.
#include "parser_line.hpp"

#include <ano/image_length.hpp>

using namespace parsing;

namespace parser_images_tests {
namespace {

// 160x120 grey pixels in one frame.
Bytes picture(std::uint8_t color = 0, std::uint16_t width = 160, std::uint16_t height = 120, std::size_t pixels = 160 * 120) {
    Bytes data{1,
               0,
               color,
               static_cast<std::uint8_t>(width),
               static_cast<std::uint8_t>(width >> 8),
               static_cast<std::uint8_t>(height),
               static_cast<std::uint8_t>(height >> 8)};
    data.resize(17 + pixels, 0x5A);
    return support::frame(0xDF, 0xFE, ano::image_id, data);
}

TEST(ParserImages, an_image_of_19217_bytes_passes_by_default_however_it_is_split) {
    for (const std::size_t at_once : {std::size_t{1}, std::size_t{7}, std::size_t{64}, std::size_t{5000}, SIZE_MAX}) {
        Line line;
        line.put(numbered(1) + picture() + numbered(2) + picture(), at_once);
        EXPECT_EQ(line.frames, (Frames{numbered(1), picture(), numbered(2), picture()})) << at_once;
        EXPECT_EQ(line.counters().skipped_bytes, 0u);
    }
    Line datagrams;
    datagrams.feed_datagram(picture());
    EXPECT_EQ(datagrams.frames, Frames{picture()});
}

TEST(ParserImages, a_small_max_data_applies_to_images_too) {
    Line line{{.max_data = 255}};
    line.put(picture() + numbered(1));
    EXPECT_EQ(line.frames, Frames{numbered(1)});
    EXPECT_EQ(line.counters().bad_length, 1u);
    Line larger{{.max_data = 19'217}};
    larger.put(picture());
    EXPECT_EQ(larger.frames, Frames{picture()});
}

TEST(ParserImages, longer_ones_are_recognised_however_their_bytes_arrive) {
    for (const std::size_t at_once : {std::size_t{1}, std::size_t{7}, SIZE_MAX}) {
        Line line;
        line.put(picture(0, 188, 120, 188 * 120) + picture(0, 188, 120, 188 * 120) + numbered(1), at_once);
        EXPECT_EQ(line.frames, Frames{numbered(1)});
        EXPECT_EQ(line.counters().long_images, 2u) << at_once;
        EXPECT_EQ(line.parser.longest_image(), 22'577u) << at_once;
    }
    Line noise;
    for (unsigned i = 0; i < 1000; ++i)
        noise.put(Bytes{0xAB, 1, 2, ano::image_id, 0xFF, 0xFF} + Bytes(30, static_cast<std::uint8_t>(i)));
    EXPECT_EQ(noise.counters().long_images, 0u);
    EXPECT_EQ(noise.parser.longest_image(), 0u);
}

TEST(ParserImages, an_image_of_bits_may_have_rows_of_width_over_8_rounded_either_way) {
    for (const std::size_t row : {125u, 126u}) {
        Line line;
        line.put(picture(1, 1001, 100, 50 * row));
        EXPECT_EQ(line.frames.size(), 1u) << row;
    }
}

// As for all other frames: later frames must not wait for the 20,000 bytes that a false header claims.
TEST(ParserImages, a_header_whose_pixel_count_does_not_fit_its_rows_is_rejected_immediately) {
    for (const Bytes& wrong : {picture(7), picture(0, 0), picture(0, 160, 0), picture(0, 161), picture(0, 160, 30)}) {
        Line line;
        line.put(begin_of(wrong, ano::image_head_size));
        EXPECT_EQ(line.parser.waiting(), 0u);
        EXPECT_EQ(line.counters().bad_length, 1u);
    }
    Line line;
    line.put(numbered(1) + header(20'000, 0xDC, ano::image_id) + numbered(2));
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2)})) << "in the same turn";
}

TEST(ParserImages, a_header_without_its_image_waits_no_longer_than_one_of_another_frame) {
    Line line{{.line_rate = 11'520}};
    line.put(header(20'000, 0xDC, ano::image_id) + Bytes(8));
    const auto begun = line.now;
    EXPECT_EQ(line.parser.deadline(), begun + 50ms);
    line.pass(50ms);
    line.expire();
    EXPECT_EQ(line.parser.deadline(), begun + 200ms + ano::Duration{std::chrono::seconds{8 + 4096}} / 11'520);
}

TEST(ParserImages, an_incomplete_image_blocks_the_line_for_at_most_its_transmission_time) {
    Line line{{.line_rate = 11'520}};
    line.put(numbered(1) + picture() + begin_of(picture(), 2000));
    const auto begun = line.now;
    const auto by = begun + 200ms + ano::Duration{std::chrono::seconds{picture().size()}} / 11'520;
    for (unsigned n = 0; line.now < by + 40ms; ++n) {
        line.put(numbered(n));
        line.pass(40ms);
        line.expire();
    }
    EXPECT_GT(line.frames.size(), 40u) << "none is lost";
    EXPECT_EQ(line.counters().expired, 1u);
}

// Frames of known senders free the line sooner if the image is not credible because its address is unknown.
TEST(ParserImages, an_image_of_an_unknown_sender_is_abandoned_for_two_valid_frames) {
    Line line;
    line.put(numbered(1) + begin_of(picture(), 100) + numbered(2) + numbered(3));
    EXPECT_EQ(line.frames, (Frames{numbered(1), numbered(2), numbered(3)}));
}

// 20 ports of a gateway: memory is touched only for images.
TEST(ParserImages, a_busy_line_without_images_does_not_use_more_of_the_buffer) {
    FrameParser parser{{}};
    const std::uint8_t* const first = parser.prepare().data();
    std::size_t reach = 0;
    const Bytes frames = numbered(1) + begin_of(numbered(2), 7);
    Bytes rest = rest_of(numbered(2), 7);
    for (int i = 0; i < 20'000; ++i) {
        for (const Bytes& bytes : {frames, rest}) {
            const auto room = parser.prepare();
            ASSERT_GE(room.size(), 4096u);
            reach = std::max(reach, static_cast<std::size_t>(room.data() + room.size() - first));
            std::copy(bytes.begin(), bytes.end(), room.begin());
            parser.commit(bytes.size(), {});
            while (parser.next()) {}
            rest = rest_of(numbered(2), 7);
        }
        if (i % 3 == 0) rest = begin_of(rest, rest.size());
    }
    EXPECT_LE(reach, 2 * (ano::overhead + 4096) + 4096);
}

}    // namespace
}    // namespace parser_images_tests
