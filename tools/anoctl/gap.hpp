// Bytes between good frames: which of them are whole frames with wrong check bytes.
#pragma once
#include <ano/frame.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace anoctl {

/// Some bytes of a gap. With `right`, a frame whose LEN fits and whose check bytes would have to be these.
struct GapPart {
    std::span<const std::uint8_t> bytes;
    std::optional<ano::Checks> right;
};

/// All of `gap`, in order. A frame with wrong check bytes is known where the gap begins, behind another one, and where it
/// reaches to the end of the gap; what begins elsewhere may be anything.
std::vector<GapPart> parts_of(std::span<const std::uint8_t> gap);

}    // namespace anoctl
