// The CRC-32 of zip, PNG and MCAP.
#pragma once
#include <cstdint>
#include <string_view>

namespace anogate {

/// The CRC of bytes that are added piece by piece.
class Crc32 {
public:
    void add(std::string_view bytes) noexcept;
    std::uint32_t value() const noexcept { return ~state_; }

private:
    std::uint32_t state_ = 0xFFFFFFFF;
};

inline std::uint32_t crc32_of(std::string_view bytes) noexcept {
    Crc32 crc;
    crc.add(bytes);
    return crc.value();
}

}    // namespace anogate
