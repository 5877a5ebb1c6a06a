// The settings of a USB device of class HID.
#pragma once
#include <link/v7_settings.hpp>

#include <string>

namespace anogate {

struct HidSettings {
    std::string device;    // "/dev/hidraw0", or a USB id: "66CC", "0483:A005"
    V7LinkSettings v7{};
    bool operator==(const HidSettings&) const = default;
};

}    // namespace anogate
