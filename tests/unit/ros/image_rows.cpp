#include <ros/image_rows.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <support/bytes.hpp>
#include <support/ros_definition.hpp>

#include <ros/cdr_encoder.hpp>
#include <ros/standard_messages.hpp>

namespace image_rows_tests {
namespace {

using namespace anogate;
using support::Bytes;
using support::operator+;

constexpr std::uint64_t second = 1'000'000'000;
constexpr std::uint8_t image_id = 0xB0;

/// Rows of an image; `flag` is the sender's number of the image.
Bytes rows(unsigned flag, std::uint8_t color, unsigned width, unsigned height, const Bytes& pixels) {
    const auto low = [](unsigned n) { return static_cast<std::uint8_t>(n); };
    Bytes data{low(flag), low(flag >> 8), color, low(width), low(width >> 8), low(height), low(height >> 8)};
    return data + Bytes(10) + pixels;
}

/// The pixels of the image that these rows complete; empty: none.
Bytes ended(ImageRows& images, const Bytes& data, std::uint64_t time_ns = second, std::uint64_t sender = 1) {
    const ano::Reading reading = ano::read(image_id, data);
    const WholeImage* const image = reading ? images.receive(sender, reading, time_ns) : nullptr;
    return image != nullptr ? Bytes(image->pixels.begin(), image->pixels.end()) : Bytes{};
}

TEST(ImageRows, an_image_is_complete_with_its_last_row) {
    ImageRows images;
    EXPECT_EQ(ended(images, rows(7, 0, 2, 3, {1, 2})), Bytes{});
    EXPECT_EQ(ended(images, rows(7, 0, 2, 3, {3, 4, 5, 6})), (Bytes{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(ended(images, rows(7, 0, 2, 3, {1, 2, 3, 4, 5, 6})), (Bytes{1, 2, 3, 4, 5, 6}));
}

TEST(ImageRows, one_bit_per_pixel_is_black_or_white) {
    ImageRows images;
    EXPECT_EQ(ended(images, rows(0, 2, 10, 1, {0x81, 0x40})), (Bytes{255, 0, 0, 0, 0, 0, 0, 255, 0, 255}));
}

TEST(ImageRows, an_image_that_lost_a_frame_is_not_returned) {
    ImageRows images;
    ended(images, rows(1, 0, 1, 3, {1}));
    EXPECT_EQ(ended(images, rows(2, 0, 1, 3, {4, 5})), Bytes{});    // another flag: the next image
    EXPECT_EQ(ended(images, rows(2, 0, 1, 3, {6})), (Bytes{4, 5, 6}));
    ended(images, rows(3, 0, 1, 3, {1, 2}));
    EXPECT_EQ(ended(images, rows(3, 0, 1, 3, {7, 8})), Bytes{});    // more than missing
    EXPECT_EQ(ended(images, rows(3, 0, 1, 3, {9})), (Bytes{7, 8, 9}));
    ended(images, rows(4, 0, 1, 2, {1}), 10 * second);
    EXPECT_EQ(ended(images, rows(4, 0, 1, 2, {2}), 11 * second + 1), Bytes{});
    EXPECT_EQ(ended(images, rows(4, 0, 1, 2, {3}), 12 * second), (Bytes{2, 3}));
}

TEST(ImageRows, senders_do_not_mix) {
    ImageRows images;
    ended(images, rows(1, 0, 1, 2, {1}), second, 1);
    EXPECT_EQ(ended(images, rows(1, 0, 1, 2, {2}), second, 2), Bytes{});
    EXPECT_EQ(ended(images, rows(1, 0, 1, 2, {3}), second, 1), (Bytes{1, 3}));
    EXPECT_EQ(ended(images, rows(1, 0, 1, 2, {4}), second, 2), (Bytes{2, 4}));
}

TEST(ImageRows, the_longest_silent_sender_is_dropped_when_there_are_too_many) {
    ImageRows images;
    for (std::uint64_t sender = 1; sender <= ImageRows::max_begun + 1; ++sender)
        EXPECT_EQ(ended(images, rows(1, 0, 1, 2, {1}), second + sender, sender), Bytes{});
    EXPECT_EQ(ended(images, rows(1, 0, 1, 2, {2}), second + 20, 2), (Bytes{1, 2}));
    EXPECT_EQ(ended(images, rows(1, 0, 1, 2, {2}), second + 21, 1), Bytes{});
}

TEST(ImageRows, invalid_images_are_ignored) {
    ImageRows images;
    EXPECT_EQ(ended(images, rows(1, 7, 1, 1, {1})), Bytes{});                                         // no colour
    EXPECT_EQ(ended(images, rows(1, 0, 0, 1, {1})), Bytes{});                                         // no width
    EXPECT_EQ(ended(images, rows(1, 0, 1, 0, {1})), Bytes{});                                         // no height
    for (int half = 0; half < 2; ++half) EXPECT_EQ(ended(images, rows(1, 0, 2, 1, {1})), Bytes{});    // half a row
    EXPECT_EQ(ended(images, rows(1, 0, 1, 1, {1, 2})), Bytes{});                                      // too many
    EXPECT_EQ(ended(images, rows(1, 0, 1, 1, {})), Bytes{});                                          // none
    for (int row = 0; row < 1024; ++row) EXPECT_EQ(ended(images, rows(1, 0, 1025, 1024, Bytes(1025))), Bytes{});
    const std::size_t pixels = ImageRows::max_pixels;
    Bytes all;
    for (std::size_t row = 0; row < 1024; ++row) all = ended(images, rows(1, 0, 1024, 1024, Bytes(1024, std::uint8_t{5})));
    EXPECT_EQ(all.size(), pixels);
}

TEST(StandardMessages, an_image_is_published_when_it_is_complete) {
    ImageRows images;
    StandardMessages camera{"fc/device_223", &images, 1}, without{"fc/device_224"};
    const Bytes first = rows(1, 0, 2, 2, {1, 2}), second_row = rows(1, 0, 2, 2, {3, 4});
    const std::uint64_t now = 1'700'000'000 * second;
    EXPECT_TRUE(camera.receive(ano::read(image_id, first), now).empty());
    const ano::Reading reading = ano::read(image_id, second_row);
    const auto told = camera.receive(reading, now + 5);
    ASSERT_EQ(told.size(), 1u);
    EXPECT_EQ(told[0], StandardTopic::image_raw);
    const StandardRow& row = standard_row(told[0]);
    EXPECT_EQ(row.name, "image_raw");
    ValueList values;
    camera.append_values(told[0], values);
    CdrEncoder encoder;
    const auto image = support::decoded_cdr(definition_of(*row.type), encoder.encode(*row.type, values.values()));
    EXPECT_EQ(image["header"]["frame_id"], "fc/device_223/camera");
    EXPECT_EQ(image["header"]["stamp"]["nanosec"], 5);
    EXPECT_EQ(image["height"], 2);
    EXPECT_EQ(image["width"], 2);
    EXPECT_EQ(image["step"], 2);
    EXPECT_EQ(image["encoding"], "mono8");
    EXPECT_EQ(image["data"], (ano::Json{1, 2, 3, 4}));
    without.receive(ano::read(image_id, first), now);
    EXPECT_TRUE(without.receive(reading, now).empty());
}

}    // namespace
}    // namespace image_rows_tests
