// The settings of a recording that is said again.
#pragma once
#include <ano/time.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct ReplaySettings {
    std::string file;
    std::uint32_t rate = 1000;                    // thousandths: so many times as fast as it was; 0: as fast as the links take it
    bool loop = false;                            // at its end, from its begin
    std::optional<ano::Duration> from{}, to{};    // since its first frame
    std::vector<std::string> links{};             // that were recorded, by name; none: all
    bool commands = false;                        // also what hosts said and what commands or changes a vehicle
    bool operator==(const ReplaySettings&) const = default;
};

}    // namespace anogate
