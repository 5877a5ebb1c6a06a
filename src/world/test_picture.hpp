// A picture to look at: a ball that goes round, in each colour of the protocol in turn, in frames of some rows.
#pragma once
#include <ano/typed.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ano::world {

class TestPicture {
public:
    static constexpr unsigned width = 48, height = 32, colors = 7;
    static constexpr std::size_t frames = 12;    // of one picture, at most

    /// The next rows of the picture; behind the last ones, the first rows of the next picture. Valid until it is called again.
    Draft<"image"> next();

private:
    void draw();
    std::uint8_t brightness(unsigned x, unsigned y) const noexcept;
    bool is_grey() const noexcept { return number_ % colors == 0; }
    std::size_t row_size() const noexcept { return is_grey() ? width : width / 8; }

    std::uint16_t number_ = 0;    // of the picture
    std::vector<std::uint8_t> pixels_;
    std::size_t sent_ = 0;
};

}    // namespace ano::world
