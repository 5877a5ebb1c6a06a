// Writes a picture as PNG.
#pragma once
#include "pictures.hpp"

#include <string>

namespace anoctl {

/// Grey pictures stay grey; those with one bit per pixel are black and their colour (mono: white). Contains the received rows. Throws
/// Failure when the library fails.
std::string png_of(const Picture& picture);

}    // namespace anoctl
