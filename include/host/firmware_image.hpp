// A file of firmware: .bia with a header, or .bin without (protocol text, section 4).
#pragma once
#include <ano/crc16.hpp>
#include <ano/fault.hpp>
#include <host/device.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace ano::host {

/// Bytes in memory or in a file, which is read in pieces: it may be too large for memory.
class FirmwareBytes {
public:
    /// Fills `into` with the bytes from `at` on; false: they can't be read. The source must live as long as the function.
    using Read = std::function<bool(std::size_t at, std::span<std::uint8_t> into)>;

    FirmwareBytes() = default;
    FirmwareBytes(std::vector<std::uint8_t> bytes);    // NOLINT(google-explicit-constructor): they are the bytes
    FirmwareBytes(std::size_t size, Read read) : size_{size}, read_{std::move(read)} {}

    std::size_t size() const noexcept { return size_; }
    bool empty() const noexcept { return size_ == 0; }
    /// False: the bytes can't be read, or there are too few.
    bool read(std::size_t at, std::span<std::uint8_t> into) const {
        return at <= size_ && into.size() <= size_ - at && (into.empty() || read_(at, into));
    }
    /// All bytes but the first `n`; `n` is at most size().
    FirmwareBytes behind(std::size_t n) const;

private:
    std::size_t size_ = 0;
    Read read_;
};

/// Why a file, or the part after its header, is probably not firmware: it begins, perhaps after padding, like a text, a form,
/// Intel HEX, a Motorola S-record, an executable of another system, UF2, PDF, a picture, an archive or a compressed file. A
/// clause, with the way to convert it if there is one; empty: it may be firmware.
std::string looks_unlike_firmware(const FirmwareBytes& file);

struct FirmwareImage {
    static constexpr std::size_t header_bytes = 100;
    static constexpr std::size_t max_bytes = std::size_t{64} << 20;

    FirmwareBytes bytes;    // without the header
    std::uint16_t version = 0;
    std::uint16_t crc = 0;    // from the header; of a .bin: computed
    std::uint8_t hw_type = 0;
    std::uint16_t hw_ver_min = 0, hw_ver_max = 0;
    std::uint32_t cmd = 0;
    bool has_header = false;

    /// True if the image is for any hardware: its hardware fields are 0.
    bool is_for_any_hardware() const noexcept { return hw_type == 0 && hw_ver_min == 0 && hw_ver_max == 0; }
    /// Why the image is not for this device; empty if it is.
    Fault misfit(const DeviceInfo& device) const;
};

/// The content of a file, or the reason why it is not firmware, as a clause.
struct FirmwareFile {
    std::optional<FirmwareImage> image;
    Fault wrong;
};
/// `crc` is used for a .bin, which is read completely for that; a .bia has its CRC in the header.
FirmwareFile read_firmware(const FirmwareBytes& file, const Crc16& crc = usual_crc16);

}    // namespace ano::host
