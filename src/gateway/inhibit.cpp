#include <gateway/inhibit.hpp>
#include <gateway/tunnel.hpp>

namespace anogate {
namespace {

constexpr std::uint8_t parameter_command = 0xE0;
constexpr std::uint8_t last_question = 3;    // device info, count, value, description

}    // namespace

bool is_control(ano::FrameView frame) noexcept {
    switch (frame.id()) {
    case 0x40:    // remote control
    case 0x41:    // realtime control
    case 0x61:    // waypoint
    case 0xC0:    // command
    case 0xE1:    // parameter value
    case 0xF0:    // firmware
        return true;
    case parameter_command: return frame.data().empty() || frame.data()[0] > last_question;
    default: return false;
    }
}

bool may_bring_control(ano::FrameView frame) noexcept {
    if (!is_tunnel_frame(frame)) return false;
    const auto content = unwrap(frame, {});
    if (!content) return true;
    if (content->inner.empty()) return false;
    InnerFrames frames{content->inner};
    while (const auto inner = frames.next())
        if (is_control(*inner) || is_tunnel_frame(*inner)) return true;
    return !frames.good();
}

}    // namespace anogate
