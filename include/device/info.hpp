// The identity of a device (protocol text, section 4, 0xE3).
#pragma once
#include <cstdint>
#include <string>

namespace ano::device {

struct Info {
    std::uint8_t id = 0;           // its address: 1 to 253, of which 1 to 199 are for users (section 2)
    std::string name{};            // at most 20 bytes
    std::uint16_t hw_ver = 100;    // the defaults are the values that devices in the field report
    std::uint16_t sw_ver = 100;
    std::uint16_t bl_ver = 0;    // 0: no boot loader
    std::uint16_t pt_ver = 800;
};

inline constexpr std::size_t max_name = 20;    // bytes of the name of a device, a parameter or a command

}    // namespace ano::device
