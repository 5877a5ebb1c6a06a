// The prefixes of the devices' topics. No I/O.
#pragma once
#include <ros2/settings.hpp>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

class Prefixes {
public:
    explicit Prefixes(const Ros2Settings& settings) : settings_{settings} {}

    /// The entry of the configuration for the device; nullptr: none.
    const Ros2Device* entry(std::uint8_t address, std::string_view link) const noexcept;

    struct Answer {
        std::string prefix;    // "drone1", "fleet/drone1"; empty: none
        std::string fault;     // why there is none; empty, too: the name of the device is not known yet
    };
    /// The prefix of a device, which keeps it: another device with the same one is refused. `name`: of the device; empty: not known.
    Answer of(std::uint8_t address, std::string_view link, std::string_view name);

private:
    std::string wanted(std::uint8_t address, std::string_view link, std::string_view name) const;

    const Ros2Settings& settings_;
    std::map<std::string, std::uint8_t> owners_;
};

}    // namespace anogate
