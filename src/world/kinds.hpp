// The kinds of simulated devices, by name.
#pragma once
#include "simulated_device.hpp"

#include <memory>
#include <string_view>

namespace ano::world {

inline constexpr std::string_view kinds = "fc|imu|flow|radio|car|lx";

/// `name` is one of the kinds; any other name returns an fc.
std::unique_ptr<SimulatedDevice> make_device(std::string_view name, const Settings& settings, TimePoint start);

}    // namespace ano::world
