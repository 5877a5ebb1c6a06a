// Upgrades the firmware of a device.
#pragma once
#include <ano/crc16.hpp>
#include <devices/works/work.hpp>
#include <host/firmware_image.hpp>

#include <memory>
#include <optional>

namespace anogate {

struct UpgradeOrder {
    ano::host::FirmwareBytes file;
    ano::Crc16 crc = ano::usual_crc16;
    bool force = false;                                 // without the check against the device's hardware
    std::optional<ano::host::DeviceInfo> known_as{};    // its earlier identity, if it is in its loader
};
std::unique_ptr<Work> upgrade(const WorkPlace& place, UpgradeOrder order);

}    // namespace anogate
