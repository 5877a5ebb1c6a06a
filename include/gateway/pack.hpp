// Which frames share a datagram.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace anogate {

/// How many of `frames`, which wait in this order, are sent in one datagram: as many as fit in `mtu` bytes, but at least one,
/// however large. 0: none waits. An `mtu` of 0 means one frame per datagram.
constexpr std::size_t frames_in_datagram(std::span<const std::span<const std::uint8_t>> frames, std::size_t mtu) noexcept {
    if (frames.empty()) return 0;
    std::size_t count = 1;
    for (std::size_t bytes = frames[0].size(); count < frames.size(); ++count) {
        bytes += frames[count].size();
        if (bytes > mtu) break;
    }
    return count;
}

}    // namespace anogate
