// A picture as a PNG.
#pragma once
#include "pictures.hpp"

#include <string>

namespace anoctl {

/// Grey is grey; a bit a pixel is black and its colour (mono: white). The rows that came, all of them when it is whole. Throws Failure
/// when the library refuses.
std::string png_of(const Picture& picture);

}    // namespace anoctl
