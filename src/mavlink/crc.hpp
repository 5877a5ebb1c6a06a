// The checksum of MAVLink packets: CRC-16/MCRF4XX.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace anogate::mavlink {

class Crc {
public:
    constexpr void add(std::uint8_t byte) noexcept {
        value_ = static_cast<std::uint16_t>(value_ >> 8 ^ table[(value_ ^ byte) & 0xFFu]);
    }
    constexpr void add(std::span<const std::uint8_t> bytes) noexcept {
        for (const std::uint8_t byte : bytes) add(byte);
    }
    constexpr void add(std::string_view text) noexcept {
        for (const char c : text) add(static_cast<std::uint8_t>(c));
    }
    constexpr std::uint16_t value() const noexcept { return value_; }

private:
    static constexpr std::array<std::uint16_t, 256> table = [] {
        std::array<std::uint16_t, 256> result{};
        for (unsigned i = 0; i < result.size(); ++i) {
            unsigned bits = i;
            for (int bit = 0; bit < 8; ++bit) bits = (bits & 1u) != 0 ? bits >> 1 ^ 0x8408u : bits >> 1;
            result[i] = static_cast<std::uint16_t>(bits);
        }
        return result;
    }();

    std::uint16_t value_ = 0xFFFF;
};

}    // namespace anogate::mavlink
