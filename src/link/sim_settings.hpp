// The settings of a simulated device and of the faults on its line.
#pragma once
#include <ano/time.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

struct SimSettings {
    std::string device = "fc";
    std::uint16_t hz = 50;      // rate of attitude and inertial frames, 1 to 100; slower frames are scaled with it
    std::uint8_t dev_id = 0;    // 0: the default of `device`
    std::uint32_t seed = 1;

    // ano::world::Faults; std::nullopt: no such fault.
    std::optional<std::uint8_t> loss{}, duplicate{}, corrupt{};    // %
    std::optional<ano::Duration> delay{}, jitter{}, deaf_after{}, slow{};
    bool operator==(const SimSettings&) const = default;
};

}    // namespace anogate
