// Work that upgrades the firmware of a device.
#pragma once
#include <ano/crc16.hpp>
#include <devices/work.hpp>

#include <memory>
#include <optional>
#include <string>

namespace anogate {

struct UpgradeOrder {
    std::shared_ptr<const std::string> file;    // its bytes
    ano::Crc16 crc = ano::usual_crc16;
    bool force = false;                                 // not checked against the device's hardware
    std::optional<ano::host::DeviceInfo> known_as{};    // of before, for a device that is left in its loader
};
std::unique_ptr<Work> upgrade(const WorkPlace& place, UpgradeOrder order);

}    // namespace anogate
