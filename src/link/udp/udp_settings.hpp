// The settings of the two kinds of UDP links.
#pragma once
#include <ano/time.hpp>
#include <gateway/host_spec.hpp>
#include <link/v7_settings.hpp>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct UdpListenSettings {
    EndpointSpec local;
    std::string interface;    // the only interface for receiving and sending; empty: any
    ano::Duration peer_timeout = std::chrono::seconds{60};
    std::uint16_t max_peers = 16;
    std::optional<std::uint16_t> max_per_address;    // std::nullopt: a quarter of max_peers, at least 2
    bool allow_any = false;
    std::vector<Network> allow;    // empty without allow_any: the networks of our interfaces
    bool trusted_any = false;
    std::vector<Network> trusted;    // networks in addition to ours; sending to their peers is not limited
    V7LinkSettings v7{};             // of every peer
    bool operator==(const UdpListenSettings&) const = default;
};

struct UdpSettings {
    HostSpec peer;
    std::optional<EndpointSpec> bind;
    std::string interface;    // as in UdpListenSettings
    V7LinkSettings v7{};
    bool operator==(const UdpSettings&) const = default;
};

}    // namespace anogate
