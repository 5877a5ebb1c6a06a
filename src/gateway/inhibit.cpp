#include <gateway/inhibit.hpp>
#include <gateway/tunnel.hpp>

namespace anogate {

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
