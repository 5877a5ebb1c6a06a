// Chinese names and texts for simulated devices. Some are cut inside a character by the size of their field, as on real devices.
#pragma once
#include "device_forms.hpp"

#include <ano/frame.hpp>

#include <cstdint>
#include <vector>

namespace ano::world {

class ChineseTexts {
public:
    explicit ChineseTexts(TextForm form) noexcept : form_{form} {}

    /// `frame`, or the same with translated texts; valid until the next call. Hosts refer to parameters and commands by number,
    /// so frames to the device need no translation.
    FrameView of(FrameView frame);

private:
    TextForm form_;
    std::vector<std::uint8_t> bytes_;
};

}    // namespace ano::world
