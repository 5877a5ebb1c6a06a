// A QR code for a terminal.
#pragma once
#include <string>

namespace anoctl {

/// Lines of half blocks, each two modules high, with a margin. `color`: black on white, independent of the colours of the
/// terminal; otherwise the light modules are drawn, for light text on a dark background. A link of 78 characters takes 19 lines
/// of 37 cells. Throws Failure if the text is too long for a code.
std::string qr_text(const std::string& text, bool color);

}    // namespace anoctl
