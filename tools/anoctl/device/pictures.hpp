// Assembles pictures from frames that contain some rows each (0xB0).
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
    std::uint8_t color = 0;    // 0: grey, one byte per pixel; 1 to 6 (message table): one bit per pixel, highest bit first
    std::size_t width = 0, height = 0;
    std::array<std::uint8_t, 10> value{};    // from the first frame
    std::vector<std::uint8_t> pixels;        // the received rows, without gaps
    double began = 0;                        // seconds since 1970
    bool is_first = false;                   // the first of its sender: if rows are missing, it may have begun before reception

    std::size_t row_bytes() const noexcept { return color == 0 ? width : (width + 7) / 8; }
    std::size_t rows() const noexcept { return pixels.size() / row_bytes(); }
    bool is_whole() const noexcept { return rows() == height; }
};

/// Frames of one picture have the same sender, flag, colour and size, and arrive in the order of the rows. Rows have no numbers.
/// Therefore a lost frame is detected only when the next picture begins: when one of these values differs, when a frame has more
/// rows than are missing, or after a pause.
class Pictures {
public:
    static constexpr ano::Duration pause = std::chrono::seconds{1};
    static constexpr std::size_t max_bytes = 64 * 1024 * 1024;    // maximum size of a picture

    /// The effect of a frame.
    struct Taken {
        std::vector<Picture> ended;    // complete pictures, and pictures with missing rows
        std::string fault;             // a clause: why the frame can't be part of a picture; empty: it can
    };
    /// `frame`: any frame; frames other than 0xB0 are ignored. `now`: its time of arrival; `time`: the same in seconds since
    /// 1970.
    Taken accept(ano::FrameView frame, ano::TimePoint now, double time);
    /// To be called after the last frame. Returns the incomplete pictures.
    std::vector<Picture> end();

private:
    struct Begun {
        Picture picture;
        ano::TimePoint last{};
    };
    std::map<std::uint8_t, Begun> begun_;    // one per sender
    std::bitset<256> heard_;                 // senders of at least one frame
};

/// "grey", "red"; empty for an undefined number.
std::string color_name(std::uint8_t color);

}    // namespace anoctl
