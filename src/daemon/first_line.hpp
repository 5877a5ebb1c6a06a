// The first and the last line of the log.
#pragma once
#include <gateway/ip.hpp>
#include <gateway/settings.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Version, source of the configuration, number of links; and for every udp-listen link the address to enter in a ground station.
/// `own`: the networks of our interfaces, with our addresses in them.
std::string first_line(const Settings& settings, std::string_view source, const std::vector<Network>& own);

/// The reason for the end, the running time, the number of frames.
std::string last_line(std::string_view why, Duration uptime, std::uint64_t frames_in, std::uint64_t frames_out);

}    // namespace anogate
