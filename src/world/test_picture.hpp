// A test picture: a ball that moves in a circle, in each colour of the protocol in turn. It is sent in frames of several rows.
#pragma once
#include <ano/typed.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ano::world {

class TestPicture {
public:
    static constexpr unsigned width = 48, height = 32, colors = 7;
    static constexpr std::size_t frames = 12;    // maximum per picture

    /// The next rows of the picture; after the last ones, the first rows of the next picture. Valid until the next call.
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
