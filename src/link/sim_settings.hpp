// The settings of a simulated device.
#pragma once
#include <cstdint>
#include <string>

namespace anogate {

struct SimSettings {
    std::string device = "fc";
    std::uint16_t hz = 50;      // of attitude and inertial frames, 1 to 100; the slower ones keep their proportion
    std::uint8_t dev_id = 0;    // 0: the usual one
    std::uint32_t seed = 1;
    bool operator==(const SimSettings&) const = default;
};

}    // namespace anogate
