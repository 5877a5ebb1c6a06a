// The settings of a replay.
#pragma once
#include <ano/time.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct ReplaySettings {
    std::string file;
    std::uint32_t rate = 1000;                    // in thousandths of the original speed; 0: as fast as possible
    bool loop = false;                            // start again at its end
    std::optional<ano::Duration> from{}, to{};    // since the first frame
    std::vector<std::string> links{};             // names of recorded links; empty: all
    bool commands = false;                        // also frames of hosts, and frames that command or change a vehicle
    bool operator==(const ReplaySettings&) const = default;
};

}    // namespace anogate
