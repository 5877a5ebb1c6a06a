#include "png.hpp"

#include <anoctl/anoctl.hpp>

#include <png.h>

#include <array>
#include <csetjmp>
#include <cstdint>

namespace anoctl {
namespace {

struct Rgb {
    std::uint8_t red, green, blue;
};
// Colours 1 to 6 of the message table.
constexpr std::array<Rgb, 6> inks{{{255, 255, 255}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 0}, {160, 32, 240}}};

void append_png(png_structp png, png_bytep bytes, std::size_t size) {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), size);
}
void flush_nothing(png_structp) {}

// On an error libpng jumps back to setjmp: no object with a destructor may be created after it.
bool write_png(png_structp png, png_infop info, const Picture& picture, std::string& out) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;    // NOLINT(bugprone-*): required by the library
    png_set_write_fn(png, &out, append_png, flush_nothing);
    const bool grey = picture.color == 0;
    png_set_IHDR(png, info, static_cast<png_uint_32>(picture.width), static_cast<png_uint_32>(picture.rows()), grey ? 8 : 1,
                 grey ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_PALETTE, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (!grey) {
        const Rgb ink = inks[picture.color - 1u];
        const png_color palette[2]{{0, 0, 0}, {ink.red, ink.green, ink.blue}};
        png_set_PLTE(png, info, palette, 2);
    }
    png_write_info(png, info);
    for (std::size_t row = 0; row < picture.rows(); ++row) png_write_row(png, picture.pixels.data() + row * picture.row_bytes());
    png_write_end(png, nullptr);
    return true;
}

}    // namespace

std::string png_of(const Picture& picture) {
    std::string out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    const bool written = info && write_png(png, info, picture, out);
    png_destroy_write_struct(&png, &info);
    if (!written) throw Failure{"libpng cannot encode this picture"};
    return out;
}

}    // namespace anoctl
