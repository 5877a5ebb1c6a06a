// A QR code for a terminal.
#pragma once
#include <string>

namespace anoctl {

/// Lines of half blocks, two modules high, with a margin. `color`: black on white whatever the terminal's colours are; otherwise the light
/// modules are drawn, for light text on a dark ground. A link of 78 characters has 19 lines of 37 cells. Throws Failure when the text is too
/// long for a code.
std::string qr_text(const std::string& text, bool color);

}    // namespace anoctl
