// One MAVLink packet.
//   version 2: FD LEN INCOMPATIBLE COMPATIBLE SEQ SYSTEM COMPONENT ID(3 bytes) PAYLOAD CRC(2) [SIGNATURE(13)]
//   version 1: FE LEN SEQ SYSTEM COMPONENT ID PAYLOAD CRC(2)
#pragma once
#include <mavlink/messages.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace anogate::mavlink {

enum class Version : std::uint8_t { v1 = 1, v2 = 2 };

inline constexpr std::uint8_t magic_v1 = 0xFE, magic_v2 = 0xFD;
inline constexpr std::size_t header_v1 = 6, header_v2 = 10, crc_size = 2, signature_size = 13;
inline constexpr std::size_t max_packet = header_v2 + max_payload + crc_size + signature_size;
inline constexpr std::uint8_t flag_signed = 0x01;    // the only incompatible flag that is defined

constexpr bool is_magic(std::uint8_t byte) noexcept { return byte == magic_v1 || byte == magic_v2; }
constexpr std::size_t header_size(std::uint8_t magic) noexcept { return magic == magic_v2 ? header_v2 : header_v1; }

/// Bytes of the packet whose header is at the beginning of `header`, which has at least 3 bytes.
constexpr std::size_t packet_size(std::span<const std::uint8_t> header) noexcept {
    const bool has_signature = header[0] == magic_v2 && (header[2] & flag_signed) != 0;
    return header_size(header[0]) + header[1] + crc_size + (has_signature ? signature_size : 0);
}

/// A packet, complete from its magic byte to the checksum or the signature.
class PacketView {
public:
    constexpr explicit PacketView(std::span<const std::uint8_t> bytes) noexcept : bytes_{bytes} {}

    constexpr std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }
    constexpr Version version() const noexcept { return is_v2() ? Version::v2 : Version::v1; }
    constexpr std::uint8_t sequence() const noexcept { return bytes_[is_v2() ? 4 : 2]; }
    constexpr std::uint8_t system() const noexcept { return bytes_[is_v2() ? 5 : 3]; }
    constexpr std::uint8_t component() const noexcept { return bytes_[is_v2() ? 6 : 4]; }
    constexpr std::uint32_t id() const noexcept {
        if (!is_v2()) return bytes_[5];
        return bytes_[7] | std::uint32_t{bytes_[8]} << 8 | std::uint32_t{bytes_[9]} << 16;
    }
    constexpr std::uint8_t incompatible_flags() const noexcept { return is_v2() ? bytes_[2] : std::uint8_t{0}; }
    constexpr bool is_signed() const noexcept { return (incompatible_flags() & flag_signed) != 0; }
    /// Version 2 leaves out zeros at the end.
    constexpr std::span<const std::uint8_t> payload() const noexcept { return bytes_.subspan(header_size(bytes_[0]), bytes_[1]); }
    /// The link id, 6 bytes of time, and 6 bytes of the hash; empty: the packet is not signed.
    constexpr std::span<const std::uint8_t> signature() const noexcept {
        return is_signed() ? bytes_.last(signature_size) : std::span<const std::uint8_t>{};
    }
    /// Whether the checksum is right by the definition of `row`.
    constexpr bool agrees_with(const Message& row) const noexcept {
        const std::size_t end = header_size(bytes_[0]) + bytes_[1];
        Crc crc;
        crc.add(bytes_.subspan(1, end - 1));
        crc.add(row.crc_extra);
        return (bytes_[end] | bytes_[end + 1] << 8) == crc.value();
    }

private:
    constexpr bool is_v2() const noexcept { return bytes_[0] == magic_v2; }

    std::span<const std::uint8_t> bytes_;
};

struct Origin {
    std::uint8_t system = 0, component = 0;
    bool operator==(const Origin&) const = default;
};

/// Writes a packet of the message to the beginning of `out` and returns its size; `payload` has row.size bytes. Returns 0 and writes
/// nothing if `out` is too small, or if version 1 has no such id. `flags`: the incompatible flags of version 2; a signature follows the
/// packet and is not counted.
constexpr std::size_t encode(std::span<std::uint8_t> out, Version version, Origin origin, std::uint8_t sequence,
                             const Message& row, std::span<const std::uint8_t> payload, std::uint8_t flags = 0) noexcept {
    constexpr std::uint32_t max_id_v1 = 255;
    const bool is_v2 = version == Version::v2;
    std::size_t length = is_v2 ? row.size : row.base_size;
    while (is_v2 && length > 1 && payload[length - 1] == 0) --length;
    const std::size_t header = is_v2 ? header_v2 : header_v1, size = header + length + crc_size;
    if (out.size() < size || (!is_v2 && row.id > max_id_v1)) return 0;
    const auto byte = [](std::uint32_t value) { return static_cast<std::uint8_t>(value); };
    if (is_v2) {
        const std::array<std::uint8_t, header_v2> bytes{magic_v2,
                                                        byte(static_cast<std::uint32_t>(length)),
                                                        flags,
                                                        0,
                                                        sequence,
                                                        origin.system,
                                                        origin.component,
                                                        byte(row.id),
                                                        byte(row.id >> 8),
                                                        byte(row.id >> 16)};
        std::copy(bytes.begin(), bytes.end(), out.begin());
    } else {
        const std::array<std::uint8_t, header_v1> bytes{
            magic_v1, byte(static_cast<std::uint32_t>(length)), sequence, origin.system, origin.component, byte(row.id)};
        std::copy(bytes.begin(), bytes.end(), out.begin());
    }
    std::copy_n(payload.begin(), length, out.begin() + static_cast<std::ptrdiff_t>(header));
    Crc crc;
    crc.add(out.subspan(1, header - 1 + length));
    crc.add(row.crc_extra);
    out[header + length] = byte(crc.value());
    out[header + length + 1] = byte(crc.value() >> 8);
    return size;
}

/// Finds lost packets of one sender by their sequence numbers.
class SequenceWatch {
public:
    /// The number of packets that were lost before this one.
    constexpr unsigned on_packet(std::uint8_t sequence) noexcept {
        const unsigned lost = is_known_ ? static_cast<std::uint8_t>(sequence - next_) : 0;
        is_known_ = true;
        next_ = static_cast<std::uint8_t>(sequence + 1);
        return lost;
    }

private:
    bool is_known_ = false;
    std::uint8_t next_ = 0;
};

}    // namespace anogate::mavlink
