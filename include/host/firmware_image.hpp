// A file of firmware: .bia with a header, or .bin without (protocol text, section 4).
#pragma once
#include <ano/crc16.hpp>
#include <host/device.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ano::host {

struct FirmwareImage {
    static constexpr std::size_t header_bytes = 100;
    static constexpr std::size_t max_bytes = std::size_t{64} << 20;

    std::vector<std::uint8_t> bytes;    // without the header
    std::uint16_t version = 0;
    std::uint16_t crc = 0;    // of the header as it stands; of a .bin computed
    std::uint8_t hw_type = 0;
    std::uint16_t hw_ver_min = 0, hw_ver_max = 0;
    std::uint32_t cmd = 0;
    bool has_header = false;

    /// Hardware fields of 0 mean that the image is for any.
    bool is_for_any_hardware() const noexcept { return hw_type == 0 && hw_ver_min == 0 && hw_ver_max == 0; }
    /// Why it is not for this device, as a clause; nothing when it is.
    std::optional<std::string> misfit(const DeviceInfo& device) const;
};

/// What is in a file, or why it is not firmware, as a clause.
struct FirmwareFile {
    std::optional<FirmwareImage> image;
    std::string wrong;
};
/// `kind` is for a .bin; a .bia brings its CRC.
FirmwareFile read_firmware(std::span<const std::uint8_t> file, const Crc16& crc = usual_crc16);

}    // namespace ano::host
