#include <host/crc16.hpp>

namespace ano::host {
namespace {

constexpr std::uint16_t reflected(std::uint16_t bits) noexcept {
    unsigned turned = 0;
    for (int i = 0; i < 16; ++i) turned = turned << 1 | (bits >> i & 1u);
    return static_cast<std::uint16_t>(turned);
}

using Table = std::array<std::uint16_t, 256>;

Table table_of(const Crc16Kind& kind) noexcept {
    Table table{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        unsigned crc = kind.reflected ? byte : byte << 8;
        for (int bit = 0; bit < 8; ++bit) {
            if (kind.reflected) crc = (crc & 1u) != 0 ? crc >> 1 ^ reflected(kind.polynomial) : crc >> 1;
            else crc = (crc & 0x8000u) != 0 ? crc << 1 ^ kind.polynomial : crc << 1;
        }
        table[byte] = static_cast<std::uint16_t>(crc);
    }
    return table;
}

}    // namespace

std::optional<Crc16> crc16_called(std::string_view name) noexcept {
    for (std::size_t i = 0; i < crc16_kinds.size(); ++i)
        if (crc16_kinds[i].name == name) return static_cast<Crc16>(i);
    return std::nullopt;
}

std::uint16_t crc16_of(Crc16 kind, std::span<const std::uint8_t> bytes) noexcept {
    const Crc16Kind& parameters = crc16_kinds[static_cast<std::size_t>(kind)];
    const Table table = table_of(parameters);
    unsigned crc = parameters.first;
    for (const std::uint8_t byte : bytes) {
        if (parameters.reflected) crc = crc >> 8 ^ table[(crc ^ byte) & 0xFFu];
        else crc = (crc << 8 ^ table[(crc >> 8 ^ byte) & 0xFFu]) & 0xFFFFu;
    }
    return static_cast<std::uint16_t>(crc);
}

}    // namespace ano::host
