// Finds complete frames with wrong check bytes among the bytes between valid frames.
#pragma once
#include <ano/frame.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace anoctl {

/// A part of a gap. If `right` is set, the part is a frame with a matching LEN, and `right` is the correct value of its check
/// bytes.
struct GapPart {
    std::span<const std::uint8_t> bytes;
    std::optional<ano::Checks> right;
};

/// The size of the frame at the beginning of the bytes, whatever its check bytes are; 0: none, or it is incomplete.
std::size_t v8_frame_size(std::span<const std::uint8_t> bytes);
std::size_t v7_frame_size(std::span<const std::uint8_t> bytes);

/// Splits `gap` into parts, in order. A frame with wrong check bytes is recognised at the beginning of the gap, directly after
/// another one, and if it ends at the end of the gap. Elsewhere a byte with the value of HEAD is not taken for the start of a
/// frame.
std::vector<GapPart> parts_of(std::span<const std::uint8_t> gap,
                              std::size_t (*frame_size)(std::span<const std::uint8_t>) = v8_frame_size);

}    // namespace anoctl
