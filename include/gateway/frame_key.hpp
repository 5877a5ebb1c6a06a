// The key by which two equal frames are recognised.
#pragma once
#include <ano/frame.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace anogate {

/// A hash of 8 bytes or more, see frame_key().
inline std::uint64_t key_of_bytes(std::span<const std::uint8_t> all) noexcept {
    const std::uint8_t* bytes = all.data();
    const std::size_t size = all.size();
    const auto word = [bytes](std::size_t at) {
        std::uint64_t value;
        std::memcpy(&value, bytes + at, sizeof value);
        return value;
    };
    const auto mix = [](std::uint64_t hash, std::uint64_t value) {
        hash = (hash ^ value) * 0x9E3779B97F4A7C15;
        return hash ^ hash >> 29;
    };
    std::uint64_t hash = mix(0, size);
    std::size_t at = 0;
    if (size >= 64) {    // four chains, so that the multiplications of a large frame overlap
        std::array<std::uint64_t, 4> lanes{hash, hash + 1, hash + 2, hash + 3};
        for (; at + 32 <= size; at += 32)
            for (std::size_t lane = 0; lane < 4; ++lane) lanes[lane] = mix(lanes[lane], word(at + 8 * lane));
        for (const std::uint64_t lane : lanes) hash = mix(hash, lane);
    }
    for (; at + 8 <= size; at += 8) hash = mix(hash, word(at));
    return mix(hash, word(size - 8));
}

/// A hash of all bytes, in 64 bits: the same bytes always have the same key, and two different frames have the same key with a
/// probability of 1 in 10^19. The check bytes are not enough for this: of the pairs of frames with the same header, 1 in 65,536
/// has the same checks, and so does every pair in which three consecutive bytes differ by +1, -2 and +1. The hash is not
/// cryptographic: two frames with the same key can be constructed.
inline std::uint64_t frame_key(ano::FrameView frame) noexcept {
    static_assert(ano::overhead >= 8);
    return key_of_bytes(frame.bytes());
}

}    // namespace anogate
