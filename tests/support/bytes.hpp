// Whole frames as bytes that own themselves, for tests.
#pragma once
#include <ano/frame.hpp>

#include <cstdint>
#include <vector>

namespace support {

using Bytes = std::vector<std::uint8_t>;

inline Bytes frame(std::uint8_t source, std::uint8_t destination, std::uint8_t id, const Bytes& data = {}) {
    Bytes bytes(ano::overhead + data.size());
    bytes.resize(ano::encode(bytes, source, destination, id, data));
    return bytes;
}

}    // namespace support
