// Images (0xB0) are longer than all other frames. With the default limit of 4096 bytes of DATA, images may have 20,000: a camera
// sends 160x120 pixels as one frame with LEN 19,217.
#pragma once
#include <ano/frame.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace ano {

inline constexpr std::uint8_t image_id = 0xB0;
inline constexpr std::size_t usual_max_data = 4096, max_image_data = 20'000;

/// The maximum of DATA in an image if other frames have at most `max_data`. A `max_data` below the default, for small devices,
/// applies to images too.
constexpr std::size_t max_image_data_at(std::size_t max_data) noexcept {
    return max_data < usual_max_data ? max_data : std::max(max_data, max_image_data);
}
/// The maximum of DATA in a frame with this id.
constexpr std::size_t max_data_of(std::uint8_t id, std::size_t max_data) noexcept {
    return id == image_id ? max_image_data_at(max_data) : max_data;
}

/// Bytes of a frame before the first pixel: the header, flag, color, width, height, val.
inline constexpr std::size_t image_head_size = header_size + 17;

/// Whether LEN matches the colour, width and height: complete rows, and not more than the image has. `begin` has image_head_size
/// bytes. This check refuses a false header with a large LEN immediately.
constexpr bool is_plausible_image(const std::uint8_t* begin) noexcept {
    const auto u16_at = [begin](std::size_t at) { return static_cast<std::size_t>(begin[at] | begin[at + 1] << 8); };
    constexpr std::size_t color = header_size + 2, width = color + 1, height = width + 2, colors = 7;
    const std::size_t pixels = u16_at(4) + header_size - image_head_size, row = u16_at(width), rows = u16_at(height);
    if (begin[color] >= colors || row == 0 || rows == 0) return false;
    const auto has_rows_of = [=](std::size_t bytes) { return bytes > 0 && pixels % bytes == 0 && pixels / bytes <= rows; };
    if (begin[color] == 0) return has_rows_of(row);
    return has_rows_of((row + 7) / 8) || has_rows_of(row / 8);
}

}    // namespace ano
