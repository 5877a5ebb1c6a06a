#include <record/crc32.hpp>

#include <ano/wire.hpp>

#include <array>
#include <cstddef>

namespace anogate {
namespace {

constexpr std::uint32_t polynomial = 0xEDB88320;
constexpr std::size_t at_a_time = 8;    // bytes

using CrcTable = std::array<std::uint32_t, 256>;

// The first table is for a byte at the end, the others for a byte followed by one, two, … more bytes.
constexpr std::array<CrcTable, at_a_time> make_crc_tables() {
    std::array<CrcTable, at_a_time> tables{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        std::uint32_t crc = byte;
        for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ polynomial : crc >> 1;
        tables[0][byte] = crc;
    }
    for (std::size_t k = 1; k < at_a_time; ++k)
        for (std::size_t byte = 0; byte < 256; ++byte)
            tables[k][byte] = tables[k - 1][byte] >> 8 ^ tables[0][tables[k - 1][byte] & 0xFF];
    return tables;
}

constexpr std::array<CrcTable, at_a_time> crc_tables = make_crc_tables();

}    // namespace

void Crc32::add(std::string_view bytes) noexcept {
    const auto* at = reinterpret_cast<const std::uint8_t*>(bytes.data());
    const std::uint8_t* const end = at + bytes.size();
    std::uint32_t crc = state_;
    const auto& t = crc_tables;
    for (; end - at >= static_cast<std::ptrdiff_t>(at_a_time); at += at_a_time) {
        const std::uint32_t low = ano::load<std::uint32_t>(at) ^ crc, high = ano::load<std::uint32_t>(at + 4);
        crc = t[7][low & 0xFF] ^ t[6][low >> 8 & 0xFF] ^ t[5][low >> 16 & 0xFF] ^ t[4][low >> 24] ^ t[3][high & 0xFF] ^
              t[2][high >> 8 & 0xFF] ^ t[1][high >> 16 & 0xFF] ^ t[0][high >> 24];
    }
    for (; at != end; ++at) crc = crc >> 8 ^ t[0][(crc ^ *at) & 0xFF];
    state_ = crc;
}

}    // namespace anogate
