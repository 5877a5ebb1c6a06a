// Finds whole frames with wrong check bytes among the bytes between good frames.
#pragma once
#include <ano/frame.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace anoctl {

/// A part of a gap. With `right` it is a frame whose LEN fits; `right` is then the check bytes that it should have.
struct GapPart {
    std::span<const std::uint8_t> bytes;
    std::optional<ano::Checks> right;
};

/// Splits `gap` into parts, in order. A frame with wrong check bytes is recognised at the beginning of the gap, directly behind another
/// one, and when it ends where the gap ends; elsewhere the byte of HEAD may be any byte.
std::vector<GapPart> parts_of(std::span<const std::uint8_t> gap);

}    // namespace anoctl
