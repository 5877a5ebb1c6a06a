// Finds USB devices of class HID whose reports carry a byte stream.
#pragma once
#include <link/hid/hid_report.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::hid {

/// The USB id of a device.
struct UsbId {
    std::uint16_t vendor = 0;
    std::optional<std::uint16_t> product{};    // std::nullopt: any

    /// "66CC", "0483:A005": four hexadecimal digits each; std::nullopt: neither.
    static std::optional<UsbId> parse(std::string_view text);
    bool matches(const UsbId& device) const noexcept {
        return vendor == device.vendor && (!product || product == device.product);
    }
};

/// The ids of ANO's devices. 0483:A005 is STMicroelectronics' number, used by older radios and flight controllers.
constexpr UsbId ano_ids[] = {{0x66CC, {}}, {0x0483, 0xA005}};

struct Device {
    std::string path;                      // "/dev/hidraw0"
    UsbId id;                              // with its product
    std::string name;                      // of the manufacturer and the product, unchecked
    std::optional<ReportSizes> reports;    // std::nullopt: they carry no byte stream
};

/// The hidraw devices in the order of their numbers. `root` is "/", or a folder with the same structure.
std::vector<Device> devices(const std::filesystem::path& root);

}    // namespace anogate::hid
