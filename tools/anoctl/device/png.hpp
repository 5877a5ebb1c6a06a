// Writes a picture as PNG.
#pragma once
#include "pictures.hpp"

#include <string>

namespace anoctl {

/// Grey pictures stay grey. Pictures with one bit per pixel are black and their colour (mono: white). Contains only the received
/// rows. Throws Failure if libpng fails.
std::string png_of(const Picture& picture);

}    // namespace anoctl
