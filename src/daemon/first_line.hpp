// The first and the last line of the log.
#pragma once
#include <gateway/ip.hpp>
#include <gateway/settings.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Version, where the configuration is from, how many links; and what to type into a ground station, for every udp-listen link. `own`
/// are the networks of our interfaces, with our addresses in them.
std::string first_line(const Settings& settings, std::string_view source, const std::vector<Network>& own);

/// Why it ends, how long it ran, how many frames passed.
std::string last_line(std::string_view why, Duration uptime, std::uint64_t frames_in, std::uint64_t frames_out);

}    // namespace anogate
