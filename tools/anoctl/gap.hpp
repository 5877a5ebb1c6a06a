// Bytes between good frames: which of them are whole frames with wrong check bytes.
#pragma once
#include <ano/frame.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace anoctl {

/// A part of a gap. With `right`: a frame whose LEN fits, and the check bytes that it would have to have.
struct GapPart {
    std::span<const std::uint8_t> bytes;
    std::optional<ano::Checks> right;
};

/// All of `gap`, in order. A frame with wrong check bytes is recognised at the beginning of the gap, behind another one, and where
/// it ends where the gap ends; elsewhere a HEAD may be any byte.
std::vector<GapPart> parts_of(std::span<const std::uint8_t> gap);

}    // namespace anoctl
