#include <ano/wire.hpp>
#include <host/firmware_image.hpp>
#include <host/task.hpp>

#include <algorithm>
#include <string_view>

namespace ano::host {
namespace {

// Where the fields of a .bia's header stand; all other bytes of it are 0.
constexpr std::string_view magic = "bia";
constexpr std::size_t version_at = 10, crc_at = 12, hw_type_at = 20, hw_ver_min_at = 30, hw_ver_max_at = 32, cmd_at = 50;

bool begins_with_magic(std::span<const std::uint8_t> file) noexcept {
    return file.size() >= magic.size() && std::equal(magic.begin(), magic.end(), file.begin());
}

FirmwareImage with_header(std::span<const std::uint8_t> file) {
    const std::uint8_t* at = file.data();
    const auto image = file.subspan(FirmwareImage::header_bytes);
    return {{image.begin(), image.end()},
            load<std::uint16_t>(at + version_at),
            load<std::uint16_t>(at + crc_at),
            at[hw_type_at],
            load<std::uint16_t>(at + hw_ver_min_at),
            load<std::uint16_t>(at + hw_ver_max_at),
            load<std::uint32_t>(at + cmd_at),
            true};
}

}    // namespace

FirmwareFile read_firmware(std::span<const std::uint8_t> file, const Crc16& crc) {
    if (file.empty()) return {std::nullopt, "the file is empty"};
    if (file.size() > FirmwareImage::max_bytes) return {std::nullopt, "the file is larger than 64 MiB"};
    if (begins_with_magic(file)) {
        if (file.size() <= FirmwareImage::header_bytes) return {std::nullopt, "the file ends in its header: it is cut off"};
        FirmwareImage image = with_header(file);
        if (image.hw_ver_min > image.hw_ver_max)
            return {std::nullopt, "the header's range of hardware versions is empty: it is damaged"};
        return {std::move(image), {}};
    }
    FirmwareImage image;
    image.bytes.assign(file.begin(), file.end());
    image.crc = crc16_of(file, crc);
    return {std::move(image), {}};
}

std::optional<std::string> FirmwareImage::misfit(const DeviceInfo& device) const {
    if (is_for_any_hardware()) return std::nullopt;
    if (hw_type != device.dev_id) return "it is for hardware " + hex_of(hw_type) + ", the device is " + hex_of(device.dev_id);
    if (device.hw_ver < hw_ver_min || device.hw_ver > hw_ver_max)
        return "it is for hardware versions " + std::to_string(hw_ver_min) + " to " + std::to_string(hw_ver_max) +
               ", the device is " + std::to_string(device.hw_ver);
    return std::nullopt;
}

}    // namespace ano::host
