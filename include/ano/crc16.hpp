// The CRC-16 of an image. The protocol text does not define which one; these are used in the field.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace ano {

/// A CRC-16 with the parameters of CRC catalogues. `reflected`: the lowest bit of a byte is processed first. None inverts its
/// result.
struct Crc16 {
    std::string_view name;
    std::uint16_t polynomial;    // with the highest bit first, without x^16
    std::uint16_t initial;
    bool reflected;
};

inline constexpr std::array crcs16{
    Crc16{"crc16/ibm-3740", 0x1021, 0xFFFF, false},    // also called CCITT-FALSE
    Crc16{"crc16/xmodem", 0x1021, 0x0000, false},   Crc16{"crc16/kermit", 0x1021, 0x0000, true},
    Crc16{"crc16/modbus", 0x8005, 0xFFFF, true},    Crc16{"crc16/arc", 0x8005, 0x0000, true},
};
inline constexpr Crc16 usual_crc16 = crcs16[0];

/// std::nullopt: none of them has this name.
constexpr std::optional<Crc16> find_crc16(std::string_view name) noexcept {
    for (const Crc16& crc : crcs16)
        if (crc.name == name) return crc;
    return std::nullopt;
}

/// Computes the CRC of bytes that are added in parts.
class Crc16Sum {
public:
    constexpr explicit Crc16Sum(const Crc16& crc = usual_crc16) noexcept : crc_{crc}, value_{crc.initial} {}

    constexpr void add(std::span<const std::uint8_t> bytes) noexcept {
        for (const std::uint8_t byte : bytes) {
            value_ ^= (crc_.reflected ? reversed(byte, 8) : byte) << 8;
            for (int bit = 0; bit < 8; ++bit) value_ = (value_ & 0x8000u) != 0 ? value_ << 1 ^ crc_.polynomial : value_ << 1;
        }
    }
    constexpr std::uint16_t value() const noexcept {
        return static_cast<std::uint16_t>(crc_.reflected ? reversed(value_, 16) : value_);
    }

private:
    static constexpr unsigned reversed(unsigned value, unsigned bits) noexcept {
        unsigned result = 0;
        for (unsigned i = 0; i < bits; ++i) result |= (value >> i & 1u) << (bits - 1 - i);
        return result;
    }

    Crc16 crc_;
    unsigned value_;    // `initial` is the same in both bit orders; only its low 16 bits are used
};

constexpr std::uint16_t crc16_of(std::span<const std::uint8_t> bytes, const Crc16& crc = usual_crc16) noexcept {
    Crc16Sum sum{crc};
    sum.add(bytes);
    return sum.value();
}

}    // namespace ano
