// The retained message on `status`: the birth after each connection, and the will that the broker publishes after a lost one. No I/O.
#pragma once
#include <mqtt/telemetry.hpp>

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace anogate {

/// Counters that `status` shows.
struct DeliveryCounts {
    std::uint64_t published = 0, unread = 0, denied = 0, refused = 0;    // records and batches that the broker answered
    std::uint64_t spooled = 0;                                           // records that were written to the spool
    std::uint64_t dropped = 0;                                           // records that the spool dropped, or could not write
    std::uint64_t gateway_lost = 0;    // frames that the gateway dropped, because they were not received fast enough
    std::uint64_t waiting = 0;         // records in the spool

    bool operator==(const DeliveryCounts&) const = default;
};

/// Immutable, so threads may share it.
class Presence {
public:
    /// `run` identifies this run of the program; a status with another one was written before a restart.
    Presence(std::string gateway, std::string run, std::string version)
        : gateway_{std::move(gateway)}, run_{std::move(run)}, version_{std::move(version)} {}

    /// `connection`: its number in this run, from 1.
    std::string will(std::uint64_t connection) const { return offline("connection lost", connection); }
    /// `names`: of devices, by address.
    std::string birth(std::uint64_t connection, const std::set<HeardDevice>& devices,
                      const std::map<std::uint8_t, std::string>& names, const DeliveryCounts& counts) const;
    /// The program ends.
    std::string farewell(std::uint64_t connection) const { return offline("stopped", connection); }

private:
    std::string offline(std::string_view why, std::uint64_t connection) const;

    const std::string gateway_, run_, version_;
};

}    // namespace anogate
