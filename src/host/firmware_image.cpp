#include <ano/wire.hpp>
#include <host/firmware_image.hpp>
#include <host/task.hpp>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>
#include <utility>

namespace ano::host {
namespace {

// Where the fields of a .bia's header stand; all other bytes of it are 0.
constexpr std::string_view magic = "bia";
constexpr std::size_t version_at = 10, crc_at = 12, hw_type_at = 20, hw_ver_min_at = 30, hw_ver_max_at = 32, cmd_at = 50;

constexpr std::size_t piece = 16 * 1024;    // bytes that are read at a time

using Header = std::array<std::uint8_t, FirmwareImage::header_bytes>;

bool begins_with_magic(const Header& header) noexcept { return std::equal(magic.begin(), magic.end(), header.begin()); }

FirmwareImage with_header(const Header& header, FirmwareBytes bytes) {
    const std::uint8_t* at = header.data();
    return {std::move(bytes),
            load<std::uint16_t>(at + version_at),
            load<std::uint16_t>(at + crc_at),
            at[hw_type_at],
            load<std::uint16_t>(at + hw_ver_min_at),
            load<std::uint16_t>(at + hw_ver_max_at),
            load<std::uint32_t>(at + cmd_at),
            true};
}

std::optional<std::uint16_t> crc_in_pieces(const FirmwareBytes& file, const Crc16& crc) {
    Crc16Sum sum{crc};
    std::vector<std::uint8_t> room(std::min(piece, file.size()));
    for (std::size_t at = 0; at < file.size(); at += room.size()) {
        room.resize(std::min(room.size(), file.size() - at));
        if (!file.read(at, room)) return std::nullopt;
        sum.add(room);
    }
    return sum.value();
}

FirmwareFile of_bia(const FirmwareBytes& file, const Header& header) {
    if (file.size() <= header.size()) return {std::nullopt, "the file ends in its header: it is cut off"};
    FirmwareImage image = with_header(header, file.behind(header.size()));
    if (image.hw_ver_min > image.hw_ver_max)
        return {std::nullopt, "the header's range of hardware versions is empty: it is damaged"};
    return {std::move(image), {}};
}

}    // namespace

FirmwareBytes::FirmwareBytes(std::vector<std::uint8_t> bytes) : size_{bytes.size()} {
    read_ = [all = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes))](std::size_t at,
                                                                                        std::span<std::uint8_t> into) {
        std::copy_n(all->begin() + static_cast<std::ptrdiff_t>(at), into.size(), into.begin());
        return true;
    };
}

FirmwareBytes FirmwareBytes::behind(std::size_t n) const {
    return {size_ - n, [n, read = read_](std::size_t at, std::span<std::uint8_t> into) { return read(n + at, into); }};
}

FirmwareFile read_firmware(const FirmwareBytes& file, const Crc16& crc) {
    if (file.empty()) return {std::nullopt, "the file is empty"};
    if (file.size() > FirmwareImage::max_bytes) return {std::nullopt, "the file is larger than 64 MiB"};
    FirmwareFile unreadable{std::nullopt, "the file can't be read"};
    Header header{};
    if (!file.read(0, std::span{header}.first(std::min(header.size(), file.size())))) return unreadable;
    if (begins_with_magic(header)) return of_bia(file, header);
    const auto sum = crc_in_pieces(file, crc);
    if (!sum) return unreadable;
    FirmwareImage image;
    image.bytes = file;
    image.crc = *sum;
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
