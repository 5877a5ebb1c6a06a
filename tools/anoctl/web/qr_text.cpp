#include "qr_text.hpp"
#include <anoctl/anoctl.hpp>

#include <qrencode.h>

#include <cstddef>
#include <memory>

namespace anoctl {
namespace {

constexpr int margin = 2;    // modules; with four as in the standard, a code of 37 modules would exceed 24 lines

struct Free {
    void operator()(QRcode* code) const { QRcode_free(code); }
};

bool is_dark(const QRcode& code, int x, int y) {
    if (x < 0 || y < 0 || x >= code.width || y >= code.width) return false;
    return (code.data[static_cast<std::size_t>(y * code.width + x)] & 1) != 0;
}

}    // namespace

std::string qr_text(const std::string& text, bool color) {
    const std::unique_ptr<QRcode, Free> code{QRcode_encodeString8bit(text.c_str(), 0, QR_ECLEVEL_L)};
    if (!code) throw Failure{"this link is too long for a QR code: " + text};
    std::string lines;
    for (int y = -margin; y < code->width + margin; y += 2) {
        if (color) lines += "\x1b[38;5;231;48;5;16m";
        for (int x = -margin; x < code->width + margin; ++x) {
            const bool has_lower = y + 1 < code->width + margin;
            const bool upper = !is_dark(*code, x, y), lower = has_lower && !is_dark(*code, x, y + 1);
            lines += upper ? (lower ? "█" : "▀") : (lower ? "▄" : " ");
        }
        lines += color ? "\x1b[0m\n" : "\n";
    }
    return lines;
}

}    // namespace anoctl
