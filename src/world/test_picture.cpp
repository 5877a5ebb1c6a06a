#include "test_picture.hpp"
#include "fill.hpp"

#include <device/profile.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace ano::world {

std::uint8_t TestPicture::brightness(unsigned x, unsigned y) const noexcept {
    const double angle = 2 * std::numbers::pi * number_ / 24;
    const double from_x = x - width / 2.0 * (1 + 0.7 * std::cos(angle)), from_y = y - height / 2.0 * (1 + 0.6 * std::sin(angle));
    if (from_x * from_x + from_y * from_y < 36) return 255;
    return static_cast<std::uint8_t>(x * 2 + y * 2);    // darker than the ball
}

// One bit per pixel, the leftmost in the highest bit; only the ball is light.
void TestPicture::draw() {
    pixels_.assign(row_size() * height, 0);
    for (unsigned y = 0; y < height; ++y)
        for (unsigned x = 0; x < width; ++x) {
            const std::uint8_t light = brightness(x, y);
            if (is_grey()) pixels_[y * width + x] = light;
            else if (light == 255) pixels_[y * row_size() + x / 8] |= static_cast<std::uint8_t>(0x80 >> x % 8);
        }
}

Draft<"image"> TestPicture::next() {
    if (sent_ == pixels_.size()) {
        if (!pixels_.empty()) ++number_;
        draw();
        sent_ = 0;
    }
    Draft<"image"> image;
    fill<"flag">(image, number_);
    fill<"color">(image, number_ % colors);
    fill<"width">(image, width);
    fill<"height">(image, height);
    const std::size_t room = device::max_sent - image.data_size();
    const std::size_t size = std::min(room / row_size() * row_size(), pixels_.size() - sent_);
    static_cast<void>(image.set<"pixels">(Bytes{pixels_}.subspan(sent_, size)));
    sent_ += size;
    return image;
}

}    // namespace ano::world
