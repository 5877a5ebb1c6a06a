// The settings of a simulated device, and of what goes wrong on the way to it.
#pragma once
#include <ano/time.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

struct SimSettings {
    std::string device = "fc";
    std::uint16_t hz = 50;      // of attitude and inertial frames, 1 to 100; the slower ones keep their proportion
    std::uint8_t dev_id = 0;    // 0: the usual one
    std::uint32_t seed = 1;

    // None unless they are set: ano::world::Faults.
    std::optional<std::uint8_t> loss{}, duplicate{}, corrupt{};    // %
    std::optional<ano::Duration> delay{}, jitter{}, deaf_after{}, slow{};
    bool operator==(const SimSettings&) const = default;
};

}    // namespace anogate
