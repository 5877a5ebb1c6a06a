// Statistics of the valid frames of a channel. They distinguish a false header from the beginning of a real frame.
#pragma once
#include <ano/frame.hpp>

#include <array>
#include <cstdint>

namespace ano {

/// Whether frames of `id` may have any length: text, images, values that a device or a user defines, ids that are not listed.
/// `first` is the first byte of DATA: it determines whether a 0x34 is a scan or a distance.
bool is_of_free_length(std::uint8_t id, std::uint8_t first) noexcept;

/// The sources of valid frames, and the largest LEN of each id.
class Heard {
public:
    void note(FrameView frame) noexcept {
        sources_[frame.source()] = true;
        const auto length = static_cast<std::uint16_t>(frame.data().size());
        std::uint16_t& largest = max_size_[frame.id()];
        if (length > largest) largest = length;
    }
    bool source(std::uint8_t address) const noexcept { return sources_[address]; }

    /// Whether `begin`, header_size + 1 bytes or more, is credible as the beginning of a frame. It is if its source was received
    /// before, and the id may have any length or was received with at least this LEN. Tunnel frames (0xB1, 0xB2) are credible
    /// from any source.
    bool makes_credible(const std::uint8_t* begin) const noexcept;

private:
    std::array<bool, 256> sources_{};
    std::array<std::uint16_t, 256> max_size_{};    // 0: not received, or only without DATA
};

}    // namespace ano
