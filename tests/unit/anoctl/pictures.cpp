#include <anoctl/device/pictures.hpp>
#include <anoctl/device/png.hpp>

#include <gtest/gtest.h>
#include <png.h>

#include <chrono>
#include <string>
#include <vector>

#include <support/bytes.hpp>

using namespace anoctl;
using namespace std::chrono_literals;
using support::Bytes;
using support::operator+;

namespace pictures_tests {
namespace {

const ano::TimePoint start = ano::TimePoint{} + 1h;

Bytes image(std::uint16_t flag, std::uint8_t color, std::uint16_t width, std::uint16_t height, const Bytes& pixels,
            std::uint8_t source = 0xDF) {
    const auto low = [](std::uint16_t n) { return static_cast<std::uint8_t>(n); };
    const auto high = [](std::uint16_t n) { return static_cast<std::uint8_t>(n >> 8); };
    Bytes data{low(flag), high(flag), color, low(width), high(width), low(height), high(height)};
    for (std::uint8_t i = 0; i < 10; ++i) data.push_back(i);
    return support::frame(source, 0xFE, 0xB0, data + pixels);
}

Pictures::Taken accept(Pictures& pictures, const Bytes& frame, ano::TimePoint now = start) {
    return pictures.accept(ano::FrameView{frame}, now, 5.0);
}

/// Its pixels as red, green, blue.
Bytes decoded(const std::string& file, unsigned& width, unsigned& height) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    if (png_image_begin_read_from_memory(&png, file.data(), file.size()) == 0) return {};
    png.format = PNG_FORMAT_RGB;
    width = png.width;
    height = png.height;
    Bytes pixels(PNG_IMAGE_SIZE(png));
    if (png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr) == 0) return {};
    return pixels;
}

TEST(Pictures, are_made_of_rows_in_several_frames) {
    Pictures pictures;
    EXPECT_TRUE(accept(pictures, image(7, 0, 2, 3, {1, 2})).ended.empty());
    const auto taken = accept(pictures, image(7, 0, 2, 3, {3, 4, 5, 6}));
    ASSERT_EQ(taken.ended.size(), 1u);
    EXPECT_EQ(taken.ended[0].pixels, (Bytes{1, 2, 3, 4, 5, 6}));
    EXPECT_TRUE(taken.ended[0].is_whole());
    EXPECT_EQ(taken.ended[0].flag, 7);
    EXPECT_EQ(taken.ended[0].value[9], 9);
    EXPECT_TRUE(pictures.end().empty());
}

TEST(Pictures, of_two_senders_are_kept_apart) {
    Pictures pictures;
    accept(pictures, image(1, 0, 1, 2, {1}, 0xDF));
    accept(pictures, image(1, 0, 1, 2, {2}, 0x15));
    const auto first = accept(pictures, image(1, 0, 1, 2, {3}, 0xDF)).ended;
    const auto second = accept(pictures, image(1, 0, 1, 2, {4}, 0x15)).ended;
    ASSERT_EQ(first.size(), 1u);
    EXPECT_EQ(first[0].pixels, (Bytes{1, 3}));
    ASSERT_EQ(second.size(), 1u);
    EXPECT_EQ(second[0].pixels, (Bytes{2, 4}));
}

TEST(Pictures, mark_the_first_one_of_each_sender) {
    Pictures pictures;
    const auto is_first = [&](std::uint16_t flag, std::uint8_t source) {
        return accept(pictures, image(flag, 0, 1, 1, {1}, source)).ended.at(0).is_first;
    };
    EXPECT_TRUE(is_first(1, 0xDF));
    EXPECT_FALSE(is_first(2, 0xDF));
    EXPECT_TRUE(is_first(1, 0x15));
    accept(pictures, image(3, 0, 1, 2, {1}));
    EXPECT_FALSE(pictures.end().at(0).is_first);
}

TEST(Pictures, that_are_incomplete_end_when_the_next_one_begins) {
    const auto rows_of_first = [](const Bytes& next, ano::Duration later) {
        Pictures pictures;
        accept(pictures, image(1, 1, 16, 4, {1, 2, 3, 4}));
        const auto ended = accept(pictures, next, start + later).ended;
        return ended.empty() || ended[0].is_whole() ? std::size_t{0} : ended[0].rows();
    };
    EXPECT_EQ(rows_of_first(image(2, 1, 16, 4, {1, 2}), 0s), 2u) << "another flag";
    EXPECT_EQ(rows_of_first(image(1, 2, 16, 4, {1, 2}), 0s), 2u) << "another colour";
    EXPECT_EQ(rows_of_first(image(1, 1, 8, 4, {1, 2}), 0s), 2u) << "another size";
    EXPECT_EQ(rows_of_first(image(1, 1, 16, 4, {1, 2, 3, 4, 5, 6}), 0s), 2u) << "more rows than are missing";
    EXPECT_EQ(rows_of_first(image(1, 1, 16, 4, {1, 2}), 1001ms), 2u) << "a pause";
    EXPECT_EQ(rows_of_first(image(1, 1, 16, 4, {1, 2}), 1000ms), 0u) << "its next rows";
}

TEST(Pictures, that_are_incomplete_are_returned_at_the_end_of_input) {
    Pictures pictures;
    accept(pictures, image(1, 0, 1, 2, {1}));
    const auto rest = pictures.end();
    ASSERT_EQ(rest.size(), 1u);
    EXPECT_FALSE(rest[0].is_whole());
    EXPECT_TRUE(pictures.end().empty());
}

TEST(Pictures, of_one_frame_also_end_an_incomplete_picture) {
    Pictures pictures;
    accept(pictures, image(1, 0, 1, 2, {1}));
    const auto ended = accept(pictures, image(2, 0, 1, 1, {9})).ended;
    ASSERT_EQ(ended.size(), 2u);
    EXPECT_FALSE(ended[0].is_whole());
    EXPECT_EQ(ended[1].pixels, Bytes{9});
}

TEST(Pictures, are_not_made_from_frames_with_impossible_values) {
    const auto fault = [](const Bytes& frame) {
        Pictures pictures;
        auto taken = accept(pictures, frame);
        EXPECT_TRUE(taken.ended.empty());
        EXPECT_TRUE(pictures.end().empty());
        return taken.fault;
    };
    EXPECT_EQ(fault(support::frame(0xDF, 0xFE, 0xB0, Bytes(16))), "the frame is too short");
    EXPECT_EQ(fault(image(1, 7, 8, 8, {1})), "colour 7 is none");
    EXPECT_EQ(fault(image(1, 0, 0, 8, {1})), "a picture of 0x8 has no pixels");
    EXPECT_EQ(fault(image(1, 0, 8, 0, {1})), "a picture of 8x0 has no pixels");
    EXPECT_EQ(fault(image(1, 0, 65535, 65535, Bytes(65))), "a picture of 65535x65535 is too large");
    EXPECT_EQ(fault(image(1, 0, 3, 3, {})), "the frame has no rows");
    EXPECT_EQ(fault(image(1, 0, 3, 3, {1, 2, 3, 4})), "4 bytes are not a whole number of rows of 3");
    EXPECT_EQ(fault(image(1, 0, 1, 2, {1, 2, 3})), "the frame has more rows than a picture of 1x2");
    EXPECT_EQ(fault(support::frame(0xDF, 0xFE, 0x03, {1})), "") << "of other messages it knows nothing";
}

TEST(Pictures, round_the_row_size_up_to_whole_bytes) {
    Pictures pictures;
    const auto ended = accept(pictures, image(1, 1, 9, 1, {0xFF, 0x80})).ended;
    ASSERT_EQ(ended.size(), 1u);
    EXPECT_EQ(ended[0].row_bytes(), 2u);
}

TEST(Png, has_all_seven_colours) {
    const Bytes expected[]{{5, 5, 5}, {255, 255, 255}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 0}, {160, 32, 240}};
    for (std::uint8_t color = 0; color < 7; ++color) {
        Pictures pictures;
        const auto ended = accept(pictures, color == 0 ? image(1, 0, 2, 1, {5, 0}) : image(1, color, 2, 1, {0x80})).ended;
        ASSERT_EQ(ended.size(), 1u) << int{color};
        unsigned width = 0, height = 0;
        EXPECT_EQ(decoded(png_of(ended[0]), width, height), (expected[color] + Bytes{0, 0, 0})) << int{color};
        EXPECT_EQ(width, 2u);
        EXPECT_EQ(height, 1u);
        EXPECT_FALSE(color_name(color).empty());
    }
    EXPECT_EQ(color_name(5), "yellow");
    EXPECT_EQ(color_name(7), "");
}

TEST(Png, contains_only_the_received_rows) {
    Pictures pictures;
    accept(pictures, image(1, 0, 1, 5, {1, 2, 3}));
    unsigned width = 0, height = 0;
    EXPECT_EQ(decoded(png_of(pictures.end().at(0)), width, height), (Bytes{1, 1, 1, 2, 2, 2, 3, 3, 3}));
    EXPECT_EQ(height, 3u);
}

}    // namespace
}    // namespace pictures_tests
