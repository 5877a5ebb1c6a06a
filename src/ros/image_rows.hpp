// Assembles images from frames with rows of pixels (0xB0). No I/O.
//
// Frames of one image have the same flag, colour and size, and arrive in the order of the rows, which have no numbers. So an
// image is complete when it has as many rows as its height. An image with a missing frame is dropped when the next one begins, or
// after a second.
#pragma once
#include <ano/reading.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace anogate {

/// One byte per pixel, 0 to 255; only 0 and 255 for a picture with one bit per pixel.
struct WholeImage {
    std::uint32_t width = 0, height = 0;
    ano::Bytes pixels{};    // valid until the next call of ImageRows::hear()
};

class ImageRows {
public:
    static constexpr std::size_t max_pixels = 1024 * 1024;    // of an image; larger ones are ignored
    static constexpr std::size_t max_begun = 8;    // incomplete images; the one without frames for the longest time is dropped
    static constexpr std::uint64_t pause_ns = 1'000'000'000;

    /// To be called for each frame; `sender` is any number that identifies the device. nullptr: the frame completed no image.
    const WholeImage* receive(std::uint64_t sender, const ano::Reading& reading, std::uint64_t time_ns);

private:
    struct Head {
        std::uint64_t flag = 0, color = 0, width = 0, height = 0;
        friend bool operator==(const Head&, const Head&) = default;
        std::size_t row_size() const noexcept;
        std::size_t pixels() const noexcept { return static_cast<std::size_t>(width * height); }
    };
    struct Begun {
        std::uint64_t sender = 0, heard_ns = 0;
        Head head{};
        std::vector<std::uint8_t> pixels{};    // empty: unused
    };
    Begun& place_for(std::uint64_t sender);
    static void append_rows(const Head& head, ano::Bytes rows, std::vector<std::uint8_t>& pixels);

    std::array<Begun, max_begun> begun_{};
    std::vector<std::uint8_t> whole_pixels_;
    WholeImage whole_;
};

}    // namespace anogate
