// Puts pictures together out of frames that carry some rows each (0xB0).
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace anoctl {

struct Picture {
    std::uint8_t source = 0;
    std::uint16_t flag = 0;
    std::uint8_t color = 0;    // one of the table: 0 grey, a byte a pixel; 1 to 6, a bit a pixel, the highest first
    std::size_t width = 0, height = 0;
    std::array<std::uint8_t, 10> value{};    // of its first frame
    std::vector<std::uint8_t> pixels;        // the rows that came, without gaps
    double began = 0;                        // seconds since 1970
    bool is_first = false;                   // of its sender: where rows are missing, it may have begun before anybody listened

    std::size_t row_bytes() const noexcept { return color == 0 ? width : (width + 7) / 8; }
    std::size_t rows() const noexcept { return pixels.size() / row_bytes(); }
    bool is_whole() const noexcept { return rows() == height; }
};

/// Frames of one picture have the same sender, flag, colour and size, and come in the order of the rows. Rows have no numbers: a lost
/// frame is noticed when the next picture begins, which is so when one of these differs, when more rows come than are missing, or
/// behind a pause.
class Pictures {
public:
    static constexpr ano::Duration pause = std::chrono::seconds{1};
    static constexpr std::size_t max_bytes = 64 * 1024 * 1024;    // of one picture

    /// What a frame brought.
    struct Taken {
        std::vector<Picture> ended;    // whole, or with a part lost
        std::string fault;             // why the frame is none of a picture, in a clause; empty: it is
    };
    /// `frame` is any; others than 0xB0 are passed over. `now` is when it came, `time` the same since 1970.
    Taken take(ano::FrameView frame, ano::TimePoint now, double time);
    /// Those that are not whole yet: nothing more comes.
    std::vector<Picture> end();

private:
    struct Begun {
        Picture picture;
        ano::TimePoint last{};
    };
    std::map<std::uint8_t, Begun> begun_;    // one of each sender
    std::bitset<256> heard_;                 // who sent any
};

/// "grey", "red"; empty for a number that is no colour.
std::string color_name(std::uint8_t color);

}    // namespace anoctl
