// By what a frame is known again.
#pragma once
#include <ano/frame.hpp>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace anogate {

/// The header and both checks. The same bytes always have the same key; two frames of one sender that differ share a key once
/// in 65,536.
inline std::uint64_t frame_key(ano::FrameView frame) noexcept {
    std::array<std::uint8_t, 8> bytes;
    std::memcpy(bytes.data(), frame.bytes().data(), ano::header_size);
    const ano::Checks checks = frame.checks();
    bytes[6] = checks.sum;
    bytes[7] = checks.add;
    return std::bit_cast<std::uint64_t>(bytes);
}

}    // namespace anogate
